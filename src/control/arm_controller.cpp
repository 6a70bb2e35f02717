#include "raven2_trainer/control/arm_controller.h"

namespace raven2_trainer::control {

std::array<JointGains, kJointCount> gainsOf(const ControllerConfig& config, Arm arm) noexcept {
  std::array<JointGains, kJointCount> gains = config.gains;
  if (arm == Arm::kGreen) gains[kInsertion].kd = config.green_insertion_kd;
  return gains;
}

ArmController::ArmController(const ControllerConfig& config, Arm arm) noexcept
    : gravity_compensation_(config.gravity_compensation), pid_(gainsOf(config, arm)) {
  const std::array<JointGains, kJointCount> gains = gainsOf(config, arm);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (gains[j].kp > 0.0) lag_[j] = (gains[j].kd + config.viscous_friction[j]) / gains[j].kp;
  }
}

JointArray ArmController::leading(const JointTarget& target) const noexcept {
  JointArray q_d = target.q;
  for (std::size_t j = 0; j < kJointCount; ++j)
    q_d[j] += lag_[j] * target.dq[j];
  return q_d;
}

JointArray ArmController::torque(const JointArray& q_d,
                                 const JointArray& q,
                                 const JointArray& dq,
                                 const JointArray& gravity) noexcept {
  return pid_.torque(q_d, q, dq, gravity_compensation_ ? gravity : JointArray{});
}

}  // namespace raven2_trainer::control
