#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer::testing {

/** A step that every surgeon passes: nobody holds the scene's first object, for 0.3 s. */
inline ExerciseStep easyStep(const std::string& name) {
  Predicate untouched;
  untouched.kind = PredicateKind::kHeld;
  untouched.negated = 1;
  untouched.object = 0;
  return {name, {untouched}, 0.3};
}

/**
 * A shipped exercise with a drill, for a simulated surgeon that only moves about. Its timer starts with the pedal, and
 * the steps before the drill's pass without an action. The rest of the exercise and the judge are unchanged.
 * @param[in] drill "own" or a scenario.
 */
inline TrainerConfig drillConfig(const std::string& exercise, const std::string& drill, std::uint64_t seed) {
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml",
                                                   config::TrainingNames{exercise, drill, "t01", "none"});
  config.seed = seed;
  config.virtual_raven.full_homing = false;
  config.virtual_raven.homing_time = 0.3;
  config.runtime.plan_at = -1.0;
  config.console.clutch_every = 0.0;  // the pedal goes up for the drill alone
  config.exercise.begin.clear();
  for (std::uint32_t i = 0; i + 1 < config.exercise.drill.step; ++i) {
    ExerciseStep& step = config.exercise.tracks.at(0).steps.at(i);
    step = easyStep(step.name);
  }
  return config;
}

}  // namespace raven2_trainer::testing
