#include "raven2_trainer/loop/model_driver.h"

#include <algorithm>

#include "raven2_trainer/control/servo_forces.h"

namespace raven2_trainer::loop {

ModelDriver::ModelDriver(const ModelConfig& config, const ArmGeometry& geometry, physics::RavenWorld* world) noexcept
    : geometry_(geometry),
      gains_(config.gains),
      world_(*world),
      controllers_{control::ArmController(config, Arm::kGold), control::ArmController(config, Arm::kGreen)},
      twin_controllers_(controllers_) {}

void ModelDriver::allowOpenLoop(const model::RavenModel& raven, const ModelConfig& config) {
  for (const Arm arm : kArms)
    at(twins_, arm).world = std::make_unique<physics::ArmWorld>(raven, arm, config);
}

void ModelDriver::reset(Arm arm) noexcept {
  at(controllers_, arm).reset();
  at(twins_, arm).leads = false;
  at(efforts_, arm) = {};
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

void ModelDriver::applyEffort(Arm arm, JointArray* tau) const noexcept {
  const Effort& effort = at(efforts_, arm);
  if (!effort.isAny()) return;
  JointArray q{}, dq{};
  world_.jointState(arm, &q, &dq);
  const ServoJoints held = control::servoForces(*tau);
  const bool is_pushed = effort.kind != EffortKind::kNone;
  const ServoJoints forces = is_pushed ? control::servoForces(geometry_, arm, q, effort) : held;
  JointArray pushed = control::jointForces(forces, effort.has_jaw ? effort.jaw : control::jawForce(*tau));
  const JointArray gravity = effort.has_weight ? JointArray{} : world_.gravityTorque(arm);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    pushed[j] = std::clamp(pushed[j], -gains_[j].limit, gains_[j].limit);
    if (is_pushed) pushed[j] += gravity[j];
  }
  *tau = pushed;
}

PerArm<JointArray> ModelDriver::step(const PerArm<JointArray>& q_d) noexcept {
  PerArm<JointArray> tau{};
  for (const Arm arm : kArms) {
    at(tau, arm) = closedTorque(arm, at(q_d, arm));
    if (at(twins_, arm).leads) takeOver(at(twins_, arm), arm, at(q_d, arm), &at(tau, arm));
    applyEffort(arm, &at(tau, arm));
  }
  world_.step(tau);
  return tau;
}

}  // namespace raven2_trainer::loop
