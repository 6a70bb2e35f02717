#pragma once

#include <string>

#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer::config {

/** Exercise, drill, trainee and curriculum, by name. */
struct TrainingNames {
  std::string exercise{};    ///< file in the folder `exercises` without its ending, or "none"
  std::string drill{};       ///< scenario of the library that the exercise runs into, "own": its own, or "none"
  std::string trainee{};     ///< id of at most 32 of a-z, 0-9, _ and -
  std::string curriculum{};  ///< file in the folder `curricula` without its ending, or "none"
};

/**
 * Puts the names into the configuration, reads what they name and adds it to the files. With an exercise the scene is
 * the one that it asks for, and the hazard that is armed at the start is its drill; TrainerConfig::drill is then the
 * scenario's name, also where "own" was asked for.
 * @param[in,out] config with its folders and its library of scenarios.
 * @throw ConfigException for a name that is not known, listing those that are, for a drill without an exercise or in
 * one without a drill, and for errors in a file.
 */
void loadTraining(const TrainingNames& names, TrainerConfig* config);

}  // namespace raven2_trainer::config
