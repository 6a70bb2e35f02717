#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::raven {

using DacArray = std::array<std::int32_t, kJointCount>;  ///< [counts]

/** PID of one arm in motor space, and torque to DAC (raven2.md 3.4 to 3.6). Real-time safe. */
class MotorController {
 public:
  MotorController(Arm arm, const VirtualRavenConfig& config) noexcept;

  /** Capstan torques [Nm] for motor positions and velocities [rad, rad/s]. The desired velocity is never set on the
   *  robot, so kd damps; the integral has no anti-windup and is never reset. */
  JointArray torque(const JointArray& desired, const JointArray& motor, const JointArray& velocity) noexcept;

  /** Factors on kp, kd and ki of each joint from now on. */
  void scaleGains(const JointArray& factors) noexcept { scale_ = factors; }

  /** Truncated, saturated to 16 bits; 0 for what is not finite. */
  DacArray toDac(const JointArray& torque) const noexcept;

 private:
  Arm arm_;
  std::array<MotorAxis, kJointCount> axes_;
  JointArray scale_{1, 1, 1, 1, 1, 1, 1};
  JointArray integral_{};  // [rad s]
};

/** Overdrive check (raven2.md 4.5): a command above `max_inst_dac` becomes 0 and stops the robot; one above its clip is
 *  treated as the policy says, from INIT on. Grasp2 is never looked at: the robot's loop ends one joint early.
 * Real-time safe. */
class OverdriveCheck {
 public:
  explicit OverdriveCheck(const VirtualRavenConfig& config) noexcept;
  /** @param[in] clips false in E-STOP. @return true if the robot must stop. */
  bool check(bool clips, DacArray* dac) noexcept;

 private:
  bool regulate(std::size_t joint, std::int32_t* command) noexcept;

  std::array<std::int32_t, kJointCount> clip_{};  // [counts]
  std::int32_t max_inst_dac_;
  OverdrivePolicy policy_;
  int count_{0};  // policy HARD: commands above their clip, of all joints of both arms
};

}  // namespace raven2_trainer::raven
