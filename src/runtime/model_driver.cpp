#include "raven2_trainer/runtime/model_driver.h"

namespace raven2_trainer::runtime {
namespace {

control::JointPid pidOf(const ModelConfig& config, Arm arm) noexcept {
  std::array<JointGains, kJointCount> gains = config.gains;
  if (arm == Arm::kGreen) gains[kInsertion].kd = config.green_insertion_kd;
  return control::JointPid(gains);
}

}  // namespace

ModelDriver::ModelDriver(const ModelConfig& config, physics::RavenWorld* world) noexcept
    : world_(*world),
      pids_{pidOf(config, Arm::kGold), pidOf(config, Arm::kGreen)},
      gravity_compensation_(config.gravity_compensation) {}

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
