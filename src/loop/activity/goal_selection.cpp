#include "loop/activity/goal_selection.h"

namespace raven2_trainer::loop {

using control::Event;

PlanningAnswer GoalSelection::request(const Request& request) noexcept {
  switch (request.kind) {
    case RequestKind::kBeginPlanning:
      return begin(request.arm);
    case RequestKind::kRecordGoal:
      return record(request);
    case RequestKind::kEndPlanning:
      return end();
    default:
      return PlanningAnswer::kNotNow;
  }
}

PlanningAnswer GoalSelection::begin(Arm arm) noexcept {
  if (stage_.mayBegin()) raise(Event::kGoalWanted);
  PlanStore& store = planning_.store();
  if (mode() != Mode::kChoosing || store.state().status == PlanningStatus::kChoosing) return PlanningAnswer::kNotNow;
  JointArray q{}, dq{};
  stage_.arms.world().jointState(arm, &q, &dq);
  store.choose(arm, q, dq);
  return PlanningAnswer::kAccepted;
}

PlanningAnswer GoalSelection::record(Request request) noexcept {
  if (mode() != Mode::kChoosing) return PlanningAnswer::kNotNow;
  request.arm = arm();
  request.choose_arm = 0;
  request.goal = GoalKind::kJoints;
  request.goal_q = at(stage_.arms.wanted(), request.arm);
  return planning_.plan(request);
}

PlanningAnswer GoalSelection::end() noexcept {
  if (mode() != Mode::kChoosing) return PlanningAnswer::kNotNow;
  raise(Event::kPlanCancelled);
  return PlanningAnswer::kAccepted;
}

/** The hands' increments move one arm; its jaws keep the opening they have. */
void GoalSelection::tick() noexcept {
  ArmState& state = at(stage_.state.arms, arm());
  const kinematics::IkStatus status = stage_.arms.add(arm(), stage_.increments, 0.0, state.q);
  state.ik_status = static_cast<std::uint32_t>(status);
  if (status == kinematics::IkStatus::kClamped) stage_.shared.ik_clamped.add();
  stage_.useCommands();
  stage_.increments.drop();
}

/** Pure kinematics: nothing else moves, and nothing is touched. */
void GoalSelection::move() noexcept {
  stage_.arms.show(arm(), &stage_.state);
}

/** Back from where choosing led it. */
void GoalSelection::leave(Mode /*next*/) noexcept {
  const PlanStore& store = planning_.store();
  stage_.arms.world().setJointState(arm(), store.chosenFrom(), store.ratesBefore());
}

}  // namespace raven2_trainer::loop
