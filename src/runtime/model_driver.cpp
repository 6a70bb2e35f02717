#include "raven2_trainer/runtime/model_driver.h"

namespace raven2_trainer::runtime {

ModelDriver::ModelDriver(const ModelConfig& config, physics::RavenWorld* world) noexcept
    : world_(*world),
      controllers_{control::ArmController(config, Arm::kGold), control::ArmController(config, Arm::kGreen)} {}

PerArm<JointArray> ModelDriver::step(const PerArm<JointArray>& q_d) noexcept {
  PerArm<JointArray> tau{};
  for (const Arm arm : kArms) {
    JointArray q{}, dq{};
    world_.jointState(arm, &q, &dq);
    at(tau, arm) = at(controllers_, arm).torque(at(q_d, arm), q, dq, world_.gravityTorque(arm));
  }
  world_.step(tau);
  return tau;
}

}  // namespace raven2_trainer::runtime
