#include "loop/model_arms.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::loop {
namespace {

// While the pedal is up the model moves to the robot's joints, no joint faster than hands move it, so that what
// the jaws hold stays held. A robot farther away than this (first seen, homing) is another matter: the model is put
// there. Shoulder to wrist.
constexpr std::array<double, kGrasp1> kFollowReach{0.15, 0.15, 0.05, 0.8, 0.8};  // [rad, m]
constexpr std::array<double, kGrasp1> kFollowSpeed{0.5, 0.5, 0.1, 3.0, 3.0};     // [rad/s, m/s]

constexpr double kFollowTime = 0.010;  // [s] time constant of that motion: 5 mm are gone within a clutch of 60 ms

bool isWithinReach(const JointArray& q, const JointArray& target) noexcept {
  for (std::size_t j = 0; j < kFollowReach.size(); ++j) {
    if (std::abs(q[j] - target[j]) > kFollowReach[j]) return false;
  }
  return true;
}

}  // namespace

ModelArms::ModelArms(const ModelConfig& config,
                     const ArmsConfig& arms,
                     const model::RavenModel& raven,
                     const model::SceneModel& scene)
    : geometry_(arms.geometry),
      world_(raven, scene, config),
      mappers_{control::TeleopMapper(arms.geometry, Arm::kGold), control::TeleopMapper(arms.geometry, Arm::kGreen)},
      driver_(config, arms.geometry, &world_),
      collisions_(config.arm_contacts) {
  for (const Arm arm : kArms) {
    at(q_d_, arm) = arms.geometry.home;
    world_.setJointState(arm, arms.geometry.home, JointArray{});
  }
}

JointArray ModelArms::joints(Arm arm) const noexcept {
  JointArray q{}, dq{};
  world_.jointState(arm, &q, &dq);
  return q;
}

// ---- where they shall be -----------------------------------------------------------------------------------------

void ModelArms::rebase() noexcept {
  for (const Arm arm : kArms) {
    at(mappers_, arm).rebasePose(joints(arm));
    driver_.reset(arm);
    at(q_d_, arm) = at(mappers_, arm).desired();
  }
}

kinematics::IkStatus ModelArms::add(Arm arm,
                                    const Increments& increments,
                                    double dgrasp,
                                    const JointArray& now) noexcept {
  const auto status = at(mappers_, arm).add(at(increments.dp_I, arm), at(increments.dq_I, arm), dgrasp, now);
  at(q_d_, arm) = at(mappers_, arm).desired();
  return status;
}

void ModelArms::wantOnPath(Arm arm, const JointArray& q) noexcept {
  const double opening = kinematics::jawOpening(at(mappers_, arm).desired());
  at(q_d_, arm) = q;
  kinematics::setJaws(kinematics::jawMidline(q), opening, &at(q_d_, arm));
}

void ModelArms::takeOpenings(const PerArm<JointArray>& q) noexcept {
  for (const Arm arm : kArms)
    at(mappers_, arm).setOpening(kinematics::jawOpening(at(q, arm)));
}

void ModelArms::yield(Arm arm, const JointArray& now, Increments* increments) noexcept {
  if (!driver_.isPushed(arm)) return;
  at(increments->dp_I, arm) = {};
  at(increments->dq_I, arm) = kIdentityQuat;
  at(mappers_, arm).rebasePose(now);
}

// ---- how they get there ------------------------------------------------------------------------------------------

void ModelArms::prepare(bool pass_through) noexcept {
  for (const Arm arm : kArms)
    world_.setCollisions(arm, at(collisions_, arm) && !pass_through);
}

void ModelArms::drive(const PerArm<JointArray>& target, ModelState* state) noexcept {
  const PerArm<JointArray> tau = driver_.step(target);
  for (const Arm arm : kArms)
    at(state->arms, arm).tau = at(tau, arm);
}

void ModelArms::show(Arm arm, ModelState* state) noexcept {
  world_.setJointState(arm, at(q_d_, arm), JointArray{});
  for (ArmState& each : state->arms)
    each.tau = JointArray{};
}

void ModelArms::describe(Arm arm, bool touches, ArmState* state) const noexcept {
  world_.jointState(arm, &state->q, &state->dq);
  state->q_d = at(q_d_, arm);
  state->contacts = touches ? world_.contacts(arm) : 0;
  const kinematics::TipMotion tip = kinematics::tipMotion(geometry_, arm, state->q, state->dq);
  state->p_BT = toArray(tip.X_BT.p);
  state->v_BT = toArray(tip.v_BT);
  state->q_BT = toArray(Quaternion(tip.X_BT.R));
}

// ---- with the robot, and apart -----------------------------------------------------------------------------------

void ModelArms::leaveRobot() noexcept {
  if (is_apart_) return;
  is_apart_ = true;
  keepOpenings();
}

void ModelArms::keepOpenings() noexcept {
  for (const Arm arm : kArms)
    at(kept_opening_, arm) = opening(arm);
}

void ModelArms::join(const PerArm<JointArray>& robot_q) noexcept {
  is_apart_ = false;
  for (const Arm arm : kArms) {
    JointArray q = joints(arm);
    const JointArray& robot = at(robot_q, arm);
    const double opening = kinematics::jawOpening(q);
    std::copy_n(robot.begin(), kFollowReach.size(), q.begin());
    kinematics::setJaws(kinematics::jawMidline(robot), opening, &q);
    world_.setJointState(arm, q, JointArray{});
  }
}

JointArray ModelArms::follow(Arm arm, const JointArray& robot_q) noexcept {
  is_apart_ = false;
  at(mappers_, arm).rebase(robot_q);
  at(q_d_, arm) = at(mappers_, arm).desired();
  return bringTo(arm, at(q_d_, arm));
}

JointArray ModelArms::bringTo(Arm arm, const JointArray& wanted) noexcept {
  if (world_.isObstructed(arm)) return wanted;  // no harder than the controllers can
  JointArray q{}, dq{};
  world_.jointState(arm, &q, &dq);
  if (!isWithinReach(q, wanted)) {
    world_.setJointState(arm, wanted, JointArray{});
    return wanted;
  }
  for (std::size_t j = 0; j < kFollowReach.size(); ++j)
    dq[j] = std::clamp((wanted[j] - q[j]) / kFollowTime, -kFollowSpeed[j], kFollowSpeed[j]);
  world_.setJointState(arm, q, dq);
  JointArray target = driver_.leading(arm, {q, dq});
  std::copy(wanted.begin() + kGrasp1, wanted.end(), target.begin() + kGrasp1);
  return target;
}

}  // namespace raven2_trainer::loop
