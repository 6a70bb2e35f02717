#include <cmath>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/runtime/physics_loop.h"

// The part of the physics loop that chooses goals, asks for plans and executes them.

namespace raven2_trainer::runtime {
namespace {

using control::Event;

/** A plan may be kept in this mode. */
bool keepsPlan(Mode mode) noexcept {
  return mode == Mode::kPedalUp || mode == Mode::kTeleoperating || mode == Mode::kTracking || mode == Mode::kArmed ||
         mode == Mode::kExecuting || mode == Mode::kReturning || mode == Mode::kCameraMoving;
}

}  // namespace

ExecutionEnd PhysicsLoop::endBy(Event event) noexcept {
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

JointArray PhysicsLoop::modelJoints(Arm arm) const noexcept {
  JointArray q{}, dq{};
  world_.jointState(arm, &q, &dq);
  return q;
}

// ---- plans -------------------------------------------------------------------------------------------------------

/** As many as the rings hold: no answer can find its ring full, and whether one is refused follows from the record. */
void PhysicsLoop::requestPlan(Request request) noexcept {
  const bool is_busy = state_.mode == Mode::kPlanning || desk_.isFull();
  if (!is_busy) raise(Event::kPlanRequested);
  const bool is_refused = is_busy || state_.mode != Mode::kPlanning;
  desk_.answer(request.id, is_refused ? PlanningAnswer::kNotNow : PlanningAnswer::kAccepted);
  if (request.id == 0) request.id = nextOwnId();  // who asked waits for no answer, but the planner's has to be known
  if (is_refused) return desk_.refuse(request.id, thisTick());
  desk_.ask(request, {modelJoints(Arm::kGold), modelJoints(Arm::kGreen)}, thisTick());
}

/** Each plan has another one than those before it: a late answer to one that was given up is nobody else's. */
std::uint32_t PhysicsLoop::nextOwnId() noexcept {
  next_plan_id_ = next_plan_id_ < kOwnRequestIds ? next_plan_id_ + 1 : 1;
  return next_plan_id_;
}

void PhysicsLoop::handlePlanResult(const PlanResult& result) noexcept {
  const bool is_awaited = desk_.isAwaited(result);
  const PlanResult& answer = desk_.take(result, thisTick());
  if (!is_awaited) return;
  raise(answer.status == PlanStatus::kSuccess ? Event::kPlanReady : Event::kPlanFailed);
  if (state_.mode == Mode::kTracking) follower_.start(answer);
}

void PhysicsLoop::scheduledPlan() noexcept {
  if (plan_scheduled_ || config_.runtime.plan_at < 0.0) return;
  const auto due = static_cast<Tick>(std::llround(config_.runtime.plan_at / kTickSeconds));
  if (state_.session_tick < due || state_.mode != Mode::kPedalUp || pedal_) return;
  plan_scheduled_ = true;
  Request request;
  request.kind = RequestKind::kPlan;
  request.id = nextOwnId();
  requestPlan(request);
}

void PhysicsLoop::cancelPlan(const Request& request) noexcept {
  follower_.stop();
  if (state_.mode == Mode::kReturning) trial_.end(ExecutionEnd::kCancelled, thisTick());
  raise(Event::kPlanCancelled);
  desk_.forget();
  desk_.answer(request.id, PlanningAnswer::kAccepted);
}

/** What a change of mode means for what is planned. */
void PhysicsLoop::settlePlanning(Mode next, Event event) noexcept {
  if (next != Mode::kArmed && next != Mode::kExecuting) desk_.end(endBy(event), thisTick());
  const PlanningStatus status = desk_.state().status;
  const bool is_given_up = status == PlanningStatus::kPlanning || status == PlanningStatus::kChoosing;
  if (is_given_up || !keepsPlan(next)) desk_.forget();
}

/** A robot that went away may come back anywhere. */
void PhysicsLoop::loseRobot() noexcept {
  endUnderWay(ExecutionEnd::kRobotLost);
  raise(Event::kPlanCancelled);
  desk_.forget();
}

// ---- choosing a goal ---------------------------------------------------------------------------------------------

void PhysicsLoop::beginChoosing(const Request& request) noexcept {
  if (mayBegin()) raise(Event::kGoalWanted);
  const bool is_begun = state_.mode == Mode::kChoosing && desk_.state().status != PlanningStatus::kChoosing;
  desk_.answer(request.id, is_begun ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow);
  if (!is_begun) return;
  JointArray q{}, dq{};
  world_.jointState(request.arm, &q, &dq);
  desk_.choose(request.arm, q, dq);
}

void PhysicsLoop::recordGoal(Request request) noexcept {
  if (state_.mode != Mode::kChoosing) return desk_.answer(request.id, PlanningAnswer::kNotNow);
  request.arm = desk_.state().arm;
  request.choose_arm = 0;
  request.goal = GoalKind::kJoints;
  request.goal_q = at(q_d_, request.arm);
  requestPlan(request);
}

void PhysicsLoop::endChoosing(const Request& request) noexcept {
  const bool is_choosing = state_.mode == Mode::kChoosing;
  if (is_choosing) raise(Event::kPlanCancelled);
  desk_.answer(request.id, is_choosing ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow);
}

/** The masters' increments move one arm; its jaws keep the opening they have. */
void PhysicsLoop::moveGoal() noexcept {
  const Arm arm = desk_.state().arm;
  ArmState& state = at(state_.arms, arm);
  const kinematics::IkStatus status =
      at(mappers_, arm).add(at(increments_.dp_I, arm), at(increments_.dq_I, arm), 0.0, state.q);
  state.ik_status = static_cast<std::uint32_t>(status);
  if (status == kinematics::IkStatus::kClamped) shared_.ik_clamped.add();
  at(q_d_, arm) = at(mappers_, arm).desired();
  useCommands();
}

/** Pure kinematics: nothing else moves, and nothing is touched. */
void PhysicsLoop::showGoal() noexcept {
  const Arm arm = desk_.state().arm;
  world_.setJointState(arm, at(q_d_, arm), JointArray{});
  for (const Arm each : kArms)
    at(state_.arms, each).tau = JointArray{};
}

/** Where the model stands when a mode of planning begins: back from where choosing led it, or, after a path was shown,
 *  back on the robot, or on the start of the path where there is no robot. */
void PhysicsLoop::placeForPlanning(Mode before, Mode next) noexcept {
  if (before == Mode::kChoosing) {
    world_.setJointState(desk_.state().arm, desk_.chosenFrom(), desk_.ratesBefore());
  } else if (before == Mode::kTracking && (next == Mode::kChoosing || next == Mode::kPlanning)) {
    if (isRobotThere()) joinRobot();
  } else if (next == Mode::kArmed) {
    if (isRobotThere()) return joinRobot();
    const PlanResult& plan = desk_.plan();
    if (before == Mode::kTracking) world_.setJointState(plan.arm, plan.waypoints[0], JointArray{});
  }
}

// ---- executing ---------------------------------------------------------------------------------------------------

void PhysicsLoop::armPlan(const Request& request) noexcept {
  const bool may_arm = state_.mode != control::nextMode(state_.mode, Event::kPlanArmed) && isPedalUp();
  PlanningAnswer answer = may_arm ? desk_.check(request, robotJoins()) : PlanningAnswer::kNotNow;
  if (answer == PlanningAnswer::kAccepted && hasMoved()) answer = PlanningAnswer::kMoved;
  desk_.answer(request.id, answer);
  if (answer != PlanningAnswer::kAccepted) return;
  raise(Event::kPlanArmed);
  desk_.arm(request);
}

/** Since the plan was asked for. After a path was shown the model's arm is put back to where it starts. */
bool PhysicsLoop::hasMoved() noexcept {
  for (const Arm arm : kArms) {
    const bool was_shown = state_.mode == Mode::kTracking && arm == desk_.plan().arm;
    if (was_shown && !isRobotThere()) continue;
    if (desk_.hasMoved(arm, isRobotThere() ? at(robot_.arms, arm).q : modelJoints(arm))) return true;
  }
  return false;
}

/** What is armed or executed moves the robot. */
bool PhysicsLoop::movesRobot() const noexcept {
  return trial_.isUnderWay() ? trial_.onRobot() : desk_.state().on_robot != 0;
}

/** A pedal-down that would begin an execution counts only if everything still is as it was when it was armed. */
bool PhysicsLoop::mayPress() noexcept {
  if (state_.mode != Mode::kArmed) return true;
  const bool lacks_robot = movesRobot() && !robotJoins();
  const bool has_moved =
      trial_.isUnderWay() ? isRobotThere() && trial_.hasMoved(robotJoints()) : !lacks_robot && hasMoved();
  if (!lacks_robot && !has_moved) return true;
  disarm(lacks_robot ? ExecutionEnd::kRobotLost : ExecutionEnd::kMoved);
  return false;
}

void PhysicsLoop::beginExecution() noexcept {
  robot_took_ = false;
  if (trial_.isUnderWay()) {
    trial_.begin(q_d_, thisTick());
    return trial_.follow(robot_.arms);
  }
  const Arm arm = desk_.plan().arm;
  desk_.begin(modelJoints(arm), thisTick());
  path_lead_ = modelJoints(arm);
  desk_.follow(at(robot_.arms, arm).q);
  if (config_.execution.drive == ExecutionDrive::kOpenLoop) driver_.openLoop(arm);
}

/** Until the robot takes increments, and while it is not heard, what is executed stands still. */
bool PhysicsLoop::mayMoveOn() const noexcept {
  return !linked_ || (robotApplies() && state_.robot_fresh != 0);
}

/** Both get the same path, and the same lead on it, as the roll-out that the plan passed: the model its joints, the
 * robot what leads its own inverse kinematics to them. Their lags are alike, so they stay together. */
void PhysicsLoop::execute() noexcept {
  const Arm arm = desk_.plan().arm;
  const bool may_move = mayMoveOn();
  if (linked_ && !robotApplies()) desk_.follow(at(robot_.arms, arm).q);
  const control::JointTarget& target = desk_.advance(may_move);
  aimAtPath(arm, target.q);
  if (!may_move) return;  // both go on to what they were asked for last
  path_lead_ = driver_.leading(arm, {at(q_d_, arm), target.dq});
  if (!linked_) return;
  robot_took_ = true;
  const control::TipIncrement increment = desk_.increment(driver_.leading(arm, target));
  at(increments_.dp_I, arm) = increment.dp_I;
  at(increments_.dq_I, arm) = increment.dq_I;
}

/** The jaws turn along, but go on pressing on what they hold: the opening stays the one that was asked for. */
void PhysicsLoop::aimAtPath(Arm arm, const JointArray& q) noexcept {
  const double opening = kinematics::jawOpening(at(mappers_, arm).desired());
  at(q_d_, arm) = q;
  kinematics::setJaws(kinematics::jawMidline(q), opening, &at(q_d_, arm));
}

/** On what the tick before led to. */
void PhysicsLoop::superviseExecution() noexcept {
  const bool is_trial = trial_.isUnderWay();
  const auto waits = [&] { return is_trial ? trial_.waitForPedal() : desk_.waitForPedal(); };
  if (state_.mode == Mode::kArmed && !waits()) return disarm(ExecutionEnd::kNoPedal);
  if (state_.mode != Mode::kExecuting) return;
  if (movesRobot() && !linked_) return endExecution(ExecutionEnd::kRobotLost);
  // It went to PEDAL_UP by itself: to go on from where it stands now takes a new pedal-down.
  if (linked_ && robot_took_ && !robotApplies()) return endExecution(ExecutionEnd::kRobotLost);
  const ExecutionEnd end = is_trial ? trial_.supervise(state_, robot_) : desk_.supervise(state_, robot_);
  if (end != ExecutionEnd::kNone) endExecution(end);
}

/** A repeated trial that the robot knows nothing of can be repeated again. */
void PhysicsLoop::endExecution(ExecutionEnd end) noexcept {
  const Event alone = trial_.isUnderWay() ? Event::kRepeatShown : Event::kTrialEnded;
  const Event event = movesRobot() ? Event::kExecutionEnded : alone;
  endUnderWay(end);
  raise(event);
}

void PhysicsLoop::endUnderWay(ExecutionEnd end) noexcept {
  desk_.end(end, thisTick());
  trial_.end(end, thisTick());
}

void PhysicsLoop::disarm(ExecutionEnd end) noexcept {
  endUnderWay(end);
  raise(Event::kPlanCancelled);
}

}  // namespace raven2_trainer::runtime
