#include "raven2_trainer/runtime/model_driver.h"

#include <algorithm>

namespace raven2_trainer::runtime {

ModelDriver::ModelDriver(const ModelConfig& config, physics::RavenWorld* world) noexcept
    : world_(*world),
      controllers_{control::ArmController(config, Arm::kGold), control::ArmController(config, Arm::kGreen)},
      twin_controllers_(controllers_) {}

void ModelDriver::allowOpenLoop(const model::RavenModel& raven, const ModelConfig& config) {
  for (const Arm arm : kArms)
    at(twins_, arm).world = std::make_unique<physics::ArmWorld>(raven, arm, config);
}

void ModelDriver::reset(Arm arm) noexcept {
  at(controllers_, arm).reset();
  at(twins_, arm).leads = false;
}

void ModelDriver::openLoop(Arm arm) noexcept {
  Twin& twin = at(twins_, arm);
  if (twin.world == nullptr) return;
  JointArray q{}, dq{};
  world_.jointState(arm, &q, &dq);
  twin.world->setState(q, JointArray{});
  at(twin_controllers_, arm) = at(controllers_, arm);
  twin.leads = true;
}

JointArray ModelDriver::closedTorque(Arm arm, const JointArray& q_d) noexcept {
  JointArray q{}, dq{};
  world_.jointState(arm, &q, &dq);
  return at(controllers_, arm).torque(q_d, q, dq, world_.gravityTorque(arm));
}

void ModelDriver::takeOver(Twin& twin, Arm arm, const JointArray& q_d, JointArray* tau) noexcept {
  physics::ArmWorld& world = *twin.world;
  const JointArray led = at(twin_controllers_, arm).torque(q_d, world.q(), world.dq(), world.gravityTorque());
  world.step(led);
  if (world.healthy()) std::copy_n(led.begin(), static_cast<std::size_t>(kGrasp1), tau->begin());
}

PerArm<JointArray> ModelDriver::step(const PerArm<JointArray>& q_d) noexcept {
  PerArm<JointArray> tau{};
  for (const Arm arm : kArms) {
    at(tau, arm) = closedTorque(arm, at(q_d, arm));
    if (at(twins_, arm).leads) takeOver(at(twins_, arm), arm, at(q_d, arm), &at(tau, arm));
  }
  world_.step(tau);
  return tau;
}

}  // namespace raven2_trainer::runtime
