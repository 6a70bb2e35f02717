#pragma once

#include <array>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::raven {

/** Capstan torques [Nm] of the three positioning joints that the robot's software adds against gravity, with its own
 *  masses and centres, the cable coupling ignored (raven2.md 3.8). Real-time safe. */
class GravityCompensation {
 public:
  GravityCompensation(Arm arm, const VirtualRavenConfig& config) noexcept;
  std::array<double, 3> torque(const JointArray& q) const noexcept;

 private:
  std::array<Pose, 3> frames(const JointArray& q) const noexcept;

  Arm arm_;
  Matrix3 twist0_, twist1_;                    // before shoulder and elbow
  Matrix3 shaft_;                              // before the insertion, with its fixed rotation
  std::array<double, 3> capstan_per_joint_{};  // [Nm/Nm; Nm/N]
};

}  // namespace raven2_trainer::raven
