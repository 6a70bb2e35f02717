#pragma once

#include <string>

#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::model {

/** Sources of arms and scene. Refers to the configuration. */
struct ModelSource {
  const ArmsConfig& arms;
  const SceneRoles& roles;
  const std::string& robot_urdf;  ///< absolute path
  const std::string& scene_urdf;  ///< absolute path
};

}  // namespace raven2_trainer::model
