#pragma once

#include <array>

#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::raven {

/** Capstan torques [Nm] of the three positioning joints that the robot's software adds against gravity, with its own
 *  masses and centres, the cable coupling ignored (raven2.md 3.8). Real-time safe. */
class GravityCompensation {
 public:
  GravityCompensation(Arm arm, const VirtualRavenConfig& config) noexcept;
  std::array<double, 3> torque(const JointArray& q) const noexcept;

 private:
  Arm arm_;
  std::array<double, 3> capstan_per_joint_{};  // [Nm/Nm; Nm/N]
};

}  // namespace raven2_trainer::raven
