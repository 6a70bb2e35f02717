#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/faults/scenario.h"

namespace raven2_trainer {

/** config/injection.yaml: what may be injected. */
struct InjectionConfig {
  bool enable{};      ///< nothing is armed without
  bool real_robot{};  ///< the second key: the relayed stream to a real robot may be corrupted
};

}  // namespace raven2_trainer

namespace raven2_trainer::faults {

/** All scenarios, and which of them are to come. Refers to the configuration. */
struct FaultLibrary {
  const std::vector<Scenario>& scenarios;  ///< Fault::id is the position + 1
  const InjectionConfig& injection;
  const std::string& hazard;     ///< armed at the start, or "none"
  const std::string& drill;      ///< that the exercise runs into, or "none"
  const ExerciseDrill& trigger;  ///< the exercise's, of its drill
  std::uint64_t seed;
};

}  // namespace raven2_trainer::faults
