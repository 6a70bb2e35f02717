#pragma once

#include "raven2_trainer/core/scene_roles.h"

namespace raven2_trainer::testing {

/** Roles of the parts of urdf/frs_trainer.urdf (meshes/dimensions.yaml). */
inline SceneRoles frsRoles() {
  SceneRoles roles;
  roles.name = "frs_trainer";
  roles.objects = {{"ring", "ring", 1, 0.007, 0.002}};
  roles.pegs = {{"far_left", "tower_far_left", {0.044, 0.020, 0.0}, 0.026, 0.004},
                {"far_right", "tower_far_right", {0.044, -0.020, 0.0}, 0.026, 0.004},
                {"near_left", "tower_near_left", {-0.018, 0.028, 0.0}, 0.026, 0.004},
                {"near_right", "tower_near_right", {-0.018, -0.028, 0.0}, 0.026, 0.004}};
  roles.tissue = {"base_plate", "dome_wall", "dome_lid"};
  roles.points = {{"middle", {0.010, 0.0, 0.045}}};
  return roles;
}

}  // namespace raven2_trainer::testing
