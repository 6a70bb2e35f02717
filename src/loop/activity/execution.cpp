#include "loop/activity/execution.h"

namespace raven2_trainer::loop {
namespace {

using control::Event;

ExecutionEnd endBy(Event event) noexcept {
  switch (event) {
    case Event::kEmergencyStop:
      return ExecutionEnd::kEStop;
    case Event::kTimeSlip:
      return ExecutionEnd::kTimeSlip;
    case Event::kPedalReleased:
      return ExecutionEnd::kReleased;
    default:
      return ExecutionEnd::kCancelled;  // by request
  }
}

}  // namespace

// ---- a plan ------------------------------------------------------------------------------------------------------

/** On the robot, or on the start of the path where there is no robot. */
void PlanExecution::place(Mode before) noexcept {
  if (stage_.robot.isThere()) return stage_.arms.join(stage_.robot.joints());
  if (before == Mode::kTracking) stage_.arms.world().setJointState(arm(), store_.plan().waypoints[0], JointArray{});
}

/** Since the plan was asked for. After a path was shown the model's arm is put back to where it starts. */
bool PlanExecution::hasMoved() noexcept {
  const bool has_robot = stage_.robot.isThere();
  for (const Arm each : kArms) {
    const bool was_shown = stage_.mode() == Mode::kTracking && each == arm();
    if (was_shown && !has_robot) continue;
    if (store_.hasMoved(each, has_robot ? at(stage_.robot.state().arms, each).q : stage_.arms.joints(each)))
      return true;
  }
  return false;
}

void PlanExecution::begin() noexcept {
  lead_ = stage_.arms.joints(arm());
  store_.begin(lead_, stage_.thisTick());
  if (stage_.config.execution.drive == ExecutionDrive::kOpenLoop) stage_.arms.driver().openLoop(arm());
}

bool PlanExecution::advance(bool may_move) noexcept {
  const control::JointTarget& target = store_.advance(may_move);
  stage_.arms.wantOnPath(arm(), target.q);
  if (!may_move) return false;  // both go on to what they were asked for last
  const ModelDriver& driver = stage_.arms.driver();
  lead_ = driver.leading(arm(), {at(stage_.arms.wanted(), arm()), target.dq});
  if (!stage_.robot.isLinked()) return false;
  const control::TipIncrement increment = store_.increment(driver.leading(arm(), target));
  at(stage_.increments.dp_I, arm()) = increment.dp_I;
  at(stage_.increments.dq_I, arm()) = increment.dq_I;
  return true;
}

// ---- a trial's repetition ----------------------------------------------------------------------------------------

void TrialRepetition::begin() noexcept {
  store_.begin(stage_.arms.wanted(), stage_.thisTick());
}

bool TrialRepetition::advance(bool may_move) noexcept {
  stage_.arms.want(store_.advance(may_move));
  stage_.arms.takeOpenings(stage_.arms.wanted());
  if (!may_move || !stage_.robot.isLinked()) return false;
  for (const Arm arm : kArms) {
    const control::TipIncrement increment = store_.tipIncrement(arm);
    at(stage_.increments.dp_I, arm) = increment.dp_I;
    at(stage_.increments.dq_I, arm) = increment.dq_I;
    at(stage_.increments.dgrasp, arm) = store_.graspIncrement(arm);
  }
  return true;
}

// ---- either ------------------------------------------------------------------------------------------------------

Execution::Execution(Planning* planning, Trial* trial, Stage* stage) noexcept
    : Activity(stage),
      planning_(*planning),
      trial_(trial->store()),
      plan_(&planning->store(), stage),
      repetition_(&trial->store(), stage) {}

PlanningAnswer Execution::request(const Request& request) noexcept {
  if (request.kind == RequestKind::kExecutePlan) return arm(request);
  if (request.kind != RequestKind::kCancelPlan) return PlanningAnswer::kNotNow;
  cancelAll();
  return PlanningAnswer::kAccepted;
}

PlanningAnswer Execution::arm(const Request& request) noexcept {
  const bool may_arm = mode() != control::nextMode(mode(), Event::kPlanArmed) && stage_.pedal.isUp();
  if (!may_arm) return PlanningAnswer::kNotNow;
  const PlanningAnswer answer = planning_.store().check(request, stage_.robotJoins());
  if (answer != PlanningAnswer::kAccepted) return answer;
  if (plan_.hasMoved()) return PlanningAnswer::kMoved;
  raise(Event::kPlanArmed);
  planning_.store().arm(request);
  return answer;
}

void Execution::enter(Mode before) noexcept {
  if (mode() == Mode::kArmed) plan_.place(before);
  Activity::enter(before);
  if (mode() != Mode::kExecuting) return;
  robot_took_ = false;
  current().begin();
  current().followRobot();
}

/** A pedal-down that would begin it counts only if everything still is as it was when it was armed. */
bool Execution::press() noexcept {
  if (mode() != Mode::kArmed) return true;
  const bool lacks_robot = movesRobot() && !stage_.robotJoins();
  if (!lacks_robot && !current().hasMoved()) return true;
  disarm(lacks_robot ? ExecutionEnd::kRobotLost : ExecutionEnd::kMoved);
  return false;
}

void Execution::release() noexcept {
  if (mode() == Mode::kExecuting) finish(ExecutionEnd::kReleased);
}

void Execution::tick() noexcept {
  stage_.increments.drop();
  if (mode() != Mode::kExecuting) return;
  if (stage_.robot.isLinked() && !stage_.robot.applies()) current().followRobot();
  if (current().advance(stage_.robot.mayMoveOn())) robot_took_ = true;
}

void Execution::lead(PerArm<JointArray>* target) noexcept {
  if (mode() == Mode::kExecuting) current().lead(target);
}

void Execution::supervise() noexcept {
  if (mode() == Mode::kExecuting) return superviseMotion();
  if (!current().waitForPedal()) disarm(ExecutionEnd::kNoPedal);
}

void Execution::superviseMotion() noexcept {
  const RobotTie& robot = stage_.robot;
  // A robot that took increments and takes no more went to PEDAL_UP by itself. It needs a new pedal-down to go on.
  const bool is_lost = (movesRobot() && !robot.isLinked()) || (robot.isLinked() && robot_took_ && !robot.applies());
  const ExecutionEnd end = is_lost ? ExecutionEnd::kRobotLost : current().supervise();
  if (end != ExecutionEnd::kNone) finish(end);
}

void Execution::settle(Mode next, Event event) noexcept {
  if (!traitsOf(next).keeps_repeat) repetition_.end(endBy(event));
  if (traitsOf(next).activity != ActivityKind::kExecution) plan_.end(endBy(event));
}

void Execution::finish(ExecutionEnd end) noexcept {
  const Event event = movesRobot() ? Event::kExecutionEnded : current().endedAlone();
  endBoth(end);
  raise(event);
}

void Execution::disarm(ExecutionEnd end) noexcept {
  endBoth(end);
  raise(Event::kPlanCancelled);
}

void Execution::endBoth(ExecutionEnd end) noexcept {
  plan_.end(end);
  repetition_.end(end);
}

void Execution::giveUp(ExecutionEnd end) noexcept {
  if (mode() == Mode::kArmed) disarm(end);
  if (mode() == Mode::kExecuting) finish(end);
}

void Execution::cancelAll() noexcept {
  planning_.stopShowing();
  if (mode() == Mode::kReturning) repetition_.end(ExecutionEnd::kCancelled);
  raise(Event::kPlanCancelled);
  planning_.store().forget();
}

void Execution::loseRobot() noexcept {
  endBoth(ExecutionEnd::kRobotLost);
  raise(Event::kPlanCancelled);
  planning_.store().forget();
}

}  // namespace raven2_trainer::loop
