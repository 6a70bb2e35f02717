#include "raven2_trainer/runtime/model_driver.h"

namespace raven2_trainer::runtime {
namespace {

std::array<JointGains, kJointCount> gainsOf(const ModelConfig& config, Arm arm) noexcept {
  std::array<JointGains, kJointCount> gains = config.gains;
  if (arm == Arm::kGreen) gains[kInsertion].kd = config.green_insertion_kd;
  return gains;
}

}  // namespace

ModelDriver::ModelDriver(const ModelConfig& config, physics::RavenWorld* world) noexcept
    : world_(*world),
      pids_{control::JointPid(gainsOf(config, Arm::kGold)), control::JointPid(gainsOf(config, Arm::kGreen))},
      gravity_compensation_(config.gravity_compensation) {
  for (const Arm arm : kArms) {
    const std::array<JointGains, kJointCount> gains = gainsOf(config, arm);
    for (std::size_t j = 0; j < kGrasp1; ++j) {
      if (gains[j].kp > 0.0) at(lag_, arm)[j] = (gains[j].kd + config.viscous_friction[j]) / gains[j].kp;
    }
  }
}

JointArray ModelDriver::leading(Arm arm, const JointArray& q, const JointArray& dq) const noexcept {
  JointArray q_d = q;
  for (std::size_t j = 0; j < kJointCount; ++j)
    q_d[j] += at(lag_, arm)[j] * dq[j];
  return q_d;
}

PerArm<JointArray> ModelDriver::step(const PerArm<JointArray>& q_d) noexcept {
  PerArm<JointArray> tau{};
  for (const Arm arm : kArms) {
    JointArray q{}, dq{};
    world_.jointState(arm, &q, &dq);
    const JointArray feed = gravity_compensation_ ? world_.gravityTorque(arm) : JointArray{};
    at(tau, arm) = at(pids_, arm).torque(at(q_d, arm), q, dq, feed);
  }
  world_.step(tau);
  return tau;
}

}  // namespace raven2_trainer::runtime
