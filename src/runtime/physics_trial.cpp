#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/runtime/physics_loop.h"

// The part of the physics loop that keeps virtual trials and repeats them.

namespace raven2_trainer::runtime {
namespace {

using control::Event;

/** A trial is there in this mode. */
bool keepsTrial(Mode mode) noexcept {
  switch (mode) {
    case Mode::kTrial:
    case Mode::kTrialHeld:
    case Mode::kTrialReady:
    case Mode::kReturning:
    case Mode::kArmed:
    case Mode::kExecuting:
    case Mode::kCameraMoving:
      return true;
    default:
      return false;
  }
}

/** A repetition that was asked for may still come, or goes on. */
bool keepsRepeat(Mode mode) noexcept {
  return mode == Mode::kReturning || mode == Mode::kArmed || mode == Mode::kExecuting;
}

}  // namespace

PlanningAnswer PhysicsLoop::beginTrial() noexcept {
  const PlanningAnswer answer = mayBegin() ? ask(Event::kTrialWanted) : PlanningAnswer::kNotNow;
  if (answer != PlanningAnswer::kAccepted) return answer;
  if (!isRobotThere()) takeOpenings();  // it was away before, and what its jaws hold now they shall hold again
  trial_.open(isRobotThere() ? robotJoints() : standing());
  world_.saveScene(&trial_scene_);
  rehearses_ = true;
  return answer;
}

PlanningAnswer PhysicsLoop::discardTrial() noexcept {
  return isPedalUp() ? ask(Event::kTrialDiscarded) : PlanningAnswer::kNotNow;
}

/** A trial leaves nothing behind, however it ended; the scene waits until the arms are out of its way. */
void PhysicsLoop::endRehearsal() noexcept {
  const bool waits = keepsTrial(state_.mode) || state_.mode == Mode::kStopped || state_.mode == Mode::kPaused;
  if (!rehearses_ || waits) return;
  world_.restoreScene(trial_scene_);
  rehearses_ = false;
}

PlanningAnswer PhysicsLoop::repeatTrial(const Request& request) noexcept {
  const PlanningAnswer answer = checkRepeat(request);
  if (answer != PlanningAnswer::kAccepted) return answer;
  raise(Event::kRepeatWanted);
  trial_.arm(request);
  return answer;
}

PlanningAnswer PhysicsLoop::checkRepeat(const Request& request) const noexcept {
  if (state_.mode != Mode::kTrialReady || !isPedalUp()) return PlanningAnswer::kNotNow;
  if (trial_.ticks() == 0) return PlanningAnswer::kNoPlan;
  if (request.on_robot != 0 && !robotJoins()) return PlanningAnswer::kNoRobot;
  if (isRobotThere() && trial_.hasMoved(robotJoints())) return PlanningAnswer::kMoved;
  return PlanningAnswer::kAccepted;
}

void PhysicsLoop::superviseTrial() noexcept {
  if (state_.mode == Mode::kTrial && trial_.isFull()) raise(Event::kTrialDone);
}

/** The model is back where the trial began, and what is repeated finds what it found. On the robot it is for good. */
void PhysicsLoop::armRepeat() noexcept {
  const bool lacks_robot = trial_.onRobot() && !robotJoins();
  const bool has_moved = isRobotThere() && trial_.hasMoved(robotJoints());
  if (!lacks_robot && !has_moved) {
    world_.restoreScene(trial_scene_);
    rehearses_ = !trial_.onRobot();
    return raise(Event::kRepeatArmed);
  }
  trial_.end(lacks_robot ? ExecutionEnd::kRobotLost : ExecutionEnd::kMoved, thisTick());
  raise(Event::kReturned);
}

/** Both get what the trial asked for, without a lead: they lag behind it as the model did then, so the tips are where
 *  they were, when they were. */
void PhysicsLoop::repeat() noexcept {
  const bool may_move = mayMoveOn();
  if (linked_ && !robotApplies()) trial_.follow(robot_.arms);
  q_d_ = trial_.advance(may_move);
  for (const Arm arm : kArms)
    at(mappers_, arm).setOpening(kinematics::jawOpening(at(q_d_, arm)));
  if (!may_move || !linked_) return;
  robot_took_ = true;
  for (const Arm arm : kArms) {
    const control::TipIncrement increment = trial_.tipIncrement(arm);
    at(increments_.dp_I, arm) = increment.dp_I;
    at(increments_.dq_I, arm) = increment.dq_I;
    at(increments_.dgrasp, arm) = trial_.graspIncrement(arm);
  }
}

/** What a change of mode means for a trial. */
void PhysicsLoop::settleTrial(Mode next, Event event) noexcept {
  if (!keepsRepeat(next)) trial_.end(endBy(event), thisTick());
  if (!keepsTrial(next)) trial_.close();
}

}  // namespace raven2_trainer::runtime
