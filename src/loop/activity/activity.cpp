#include "loop/activity/activity.h"

namespace raven2_trainer::loop {

/** Whatever comes next starts from where the arms are. */
void Activity::enter(Mode /*before*/) noexcept {
  stage_.arms.rebase();
}

/** A robot that is not homed searches its stops, wherever that leads: a model that follows it passes through everything
 *  until then. */
void Activity::move() noexcept {
  const bool homes = stage_.robot.isUnhomed() && followsRobot();
  stage_.arms.prepare(homes || traitsOf(mode()).world == WorldMotion::kPasses);
  PerArm<JointArray> target = stage_.arms.wanted();
  lead(&target);
  stage_.arms.drive(target, &stage_.state);
}

void Activity::followRobot(PerArm<JointArray>* target) noexcept {
  if (!stage_.robot.isFresh()) return;
  for (const Arm arm : kArms)
    at(*target, arm) = stage_.arms.follow(arm, at(stage_.robot.state().arms, arm).q);
}

/** A model that goes on alone, whatever took the robot from it, has to come back. */
void Activity::aimByHand() noexcept {
  if (!stage_.robot.applies()) return stage_.increments.drop();
  if (!stage_.robot.isLinked()) stage_.arms.leaveRobot();
  bool is_clamped = false;
  for (const Arm arm : kArms) {
    ArmState& state = at(stage_.state.arms, arm);
    stage_.arms.yield(arm, state.q, &stage_.increments);
    const auto status = stage_.arms.add(arm, stage_.increments, at(stage_.increments.dgrasp, arm), state.q);
    state.ik_status = static_cast<std::uint32_t>(status);
    is_clamped = is_clamped || status == kinematics::IkStatus::kClamped;
  }
  if (is_clamped) stage_.shared.ik_clamped.add();
  stage_.useCommands();
}

}  // namespace raven2_trainer::loop
