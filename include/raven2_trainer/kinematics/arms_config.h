#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Tool and link constants of the DH chain (config/arms.yaml, `kinematics`). */
struct ArmGeometry {
  double d4{};         ///< [m] frame 3 to wrist along the shaft, -0.47 (raven2.md 2.1)
  double lw{};         ///< [m] wrist axis to frame 6, 0.013 for the Raven grasper
  JointArray q_min{};  ///< [rad, m] software limits (raven2.md 2.3)
  JointArray q_max{};  ///< [rad, m]
  JointArray home{};   ///< [rad, m]
};

/** Constants of an instrument (config/arms.yaml, `tools`). */
struct ToolPreset {
  std::string name;
  double d4{};  ///< [m] ArmGeometry::d4
  double lw{};  ///< [m] ArmGeometry::lw
};

/** config/arms.yaml */
struct ArmsConfig {
  ArmGeometry geometry{};         ///< with the chosen tool
  std::string tool;               ///< its name
  std::vector<ToolPreset> tools;  ///< all known ones, in the file's order
  PerArm<Vec3> rcm_W{};           ///< [m] remote centres of motion in W
};

}  // namespace raven2_trainer
