#pragma once

#include <memory>
#include <optional>
#include <string>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/console/surgeon_config.h"
#include "raven2_trainer/console/truth_log.h"

namespace raven2_trainer::console {

/** Choice of the surgeon. */
struct MotionChoice {
  std::string motion{"scripted"};  ///< scripted, recording:FILE, commands:FILE, expert or clumsy:NAME
  std::optional<double> reaction;  ///< [s] from a force or ghost to the pedal; empty: no reaction
};

/**
 * Motion of the console by its name: strokes in a box ("scripted"), a recording ("recording:FILE"),
 * commands of a program ("commands:FILE", console/commands_file.h), or the exercise's expert ("expert") or one of its
 * clumsy surgeons ("clumsy:NAME"). Everything random comes from the configuration's seed.
 * @param[in] truth Gets the actions and reactions of a simulated surgeon; may be null, else it must outlive the source.
 * @throw ConfigException for an unknown name (lists the known ones), an expert without an exercise or in one without an
 * expert, a reaction with "commands:FILE", and as console/script.h.
 */
std::unique_ptr<MotionSource> makeMotion(const SurgeonConfig& config,
                                         const MotionChoice& choice,
                                         TruthLog* truth = nullptr);

/** The same without a reaction. */
std::unique_ptr<MotionSource> makeMotion(const SurgeonConfig& config, const std::string& motion);

/** Name in session logs. A commands file has no path there, so a log's bytes do not depend on its place. */
std::string motionLabel(const std::string& motion);

/** Whether it is "commands:FILE". Then tick() is due from the console's first tick. */
bool isCommanded(const std::string& motion) noexcept;

/** [s] that "commands:FILE" lasts. @throw ConfigException with FILE:LINE. */
double commandedSeconds(const std::string& motion);

/** Whether it does the exercise and then finishes. */
bool doesExercise(const std::string& motion) noexcept;

}  // namespace raven2_trainer::console
