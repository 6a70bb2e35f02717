#pragma once

#include "raven2_trainer/control/controller_config.h"

namespace raven2_trainer::control {

/**
 * PD on all joints, PID on the insertion joint (paper, 3.1). The damping acts on the joint velocity, not on its error:
 * the robot's software never sets a desired velocity (raven2.md 3.6), and the model is to lag as the robot does.
 * Torques are bounded; the integral stops growing while its joint is at the bound. Real-time safe.
 */
class JointPid {
 public:
  explicit JointPid(const std::array<JointGains, kJointCount>& gains) noexcept : gains_(gains) {}

  void reset() noexcept { integral_ = {}; }

  /** [Nm; N] `feed_forward` plus the control law, bounded. */
  JointArray torque(const JointArray& q_d,
                    const JointArray& q,
                    const JointArray& dq,
                    const JointArray& feed_forward) noexcept;

 private:
  std::array<JointGains, kJointCount> gains_;
  JointArray integral_{};
};

}  // namespace raven2_trainer::control
