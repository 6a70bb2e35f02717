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
  std::optional<double> reaction;  ///< [s] from a force on a hand to the pedal; none: it is not heeded
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

/** As sessions name it: without the path of a file of commands, so that their logs have the same bytes wherever it
 * lies. */
std::string motionLabel(const std::string& motion);

/** Whether it is "commands:FILE". Call its tick() from its console's first tick on. */
bool isCommanded(const std::string& motion) noexcept;

/** [s] of "commands:FILE". @throw ConfigException with FILE:LINE. */
double commandedSeconds(const std::string& motion);

/** Whether it does the exercise, and is finished then. */
bool doesExercise(const std::string& motion) noexcept;

}  // namespace raven2_trainer::console
