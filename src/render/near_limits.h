#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/haptics/haptics_config.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** A limit of the workspace that a tool is near to. */
struct NearLimit {
  Arm arm{};
  std::string text;            ///< for the operator
  double nearness{};           ///< [-] 0 where it is shown first, to 1 at the limit and beyond
  bool is_wall{false};         ///< it stops the tip: the rest is known
  Vector3 p_W{0, 0, 0};        ///< [m] where the tip would be stopped, by this joint alone
  Vector3 along_W{0, 0, 1.0};  ///< [-] unit, the direction to it
};

/**
 * Limits of the model's joints (5 degrees or 10 mm before them; the jaws, which are often closed, are left out), and
 * the edge of the master's workspace from where it pushes the hand, if that is on. Joints that are not finite have no
 * limits.
 * @param[in] X_WB arm bases.
 */
std::vector<NearLimit> nearLimits(const ArmGeometry& geometry,
                                  const PerArm<Pose>& X_WB,
                                  const EdgeConfig& edge,
                                  const Snapshot& snapshot);

}  // namespace raven2_trainer::render
