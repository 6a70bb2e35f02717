#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::console {

/** References to configuration parts, which must outlive it. */
struct SurgeonConfig {
  const ConsoleConfig& console;
  const ArmsConfig& arms;
  const Exercise& exercise;
  const SceneRoles& roles;
  const std::string& exercise_name;  ///< or "none"
  const std::uint64_t seed;
};

}  // namespace raven2_trainer::console
