#include "loop/activity/trial.h"

namespace raven2_trainer::loop {

using control::Event;

Trial::Trial(const model::RavenModel& raven, const model::SceneModel& scene, double limit, Stage* stage)
    : Activity(stage), store_(stage->config, raven, scene, &stage->answers, &stage->shared, limit) {}

PlanningAnswer Trial::request(const Request& request) noexcept {
  switch (request.kind) {
    case RequestKind::kBeginTrial:
      return begin();
    case RequestKind::kEndTrial:
      return ask(Event::kTrialDone);
    case RequestKind::kDiscardTrial:
      return stage_.pedal.isUp() ? ask(Event::kTrialDiscarded) : PlanningAnswer::kNotNow;
    case RequestKind::kRepeatTrial:
      return repeat(request);
    default:
      return PlanningAnswer::kNotNow;
  }
}

/** Where it begins, the robot must be, too: a robot that came in this very tick may be elsewhere. */
PlanningAnswer Trial::begin() noexcept {
  const bool may_begin = stage_.mayBegin() && !stage_.mustReturn();
  const PlanningAnswer answer = may_begin ? ask(Event::kTrialWanted) : PlanningAnswer::kNotNow;
  if (answer != PlanningAnswer::kAccepted) return answer;
  const bool has_robot = stage_.robot.isThere();
  if (!has_robot) stage_.arms.keepOpenings();  // it was away before, and what its jaws hold now they shall hold again
  store_.open(has_robot ? stage_.robot.joints() : stage_.arms.joints());
  stage_.arms.world().saveScene(&scene_);
  rehearses_ = true;
  return answer;
}

void Trial::enter(Mode before) noexcept {
  Activity::enter(before);
  if (mode() == Mode::kTrial) store_.mark();
}

void Trial::supervise() noexcept {
  if (mode() == Mode::kTrial && store_.isFull()) raise(Event::kTrialDone);
}

void Trial::tick() noexcept {
  if (mode() == Mode::kTrial) return aimByHand();
  stage_.increments.drop();
}

void Trial::keep() noexcept {
  if (mode() == Mode::kTrial) store_.keep(stage_.state.arms);
}

void Trial::endRehearsal() noexcept {
  if (!rehearses_ || traitsOf(mode()).keeps_scene) return;
  stage_.arms.world().restoreScene(scene_);
  rehearses_ = false;
}

/** The execution ends its repetition. */
void Trial::settle(Mode next, Event /*event*/) noexcept {
  if (!traitsOf(next).keeps_trial) store_.close();
}

// ---- repeating it ------------------------------------------------------------------------------------------------

PlanningAnswer Trial::repeat(const Request& request) noexcept {
  const PlanningAnswer answer = checkRepeat(request);
  if (answer != PlanningAnswer::kAccepted) return answer;
  raise(Event::kRepeatWanted);
  store_.arm(request);
  return answer;
}

PlanningAnswer Trial::checkRepeat(const Request& request) const noexcept {
  if (mode() != Mode::kTrialReady || !stage_.pedal.isUp()) return PlanningAnswer::kNotNow;
  if (store_.ticks() == 0) return PlanningAnswer::kNoPlan;
  if (request.on_robot != 0 && !stage_.robotJoins()) return PlanningAnswer::kNoRobot;
  return hasMoved() ? PlanningAnswer::kMoved : PlanningAnswer::kAccepted;
}

bool Trial::hasMoved() const noexcept {
  return stage_.robot.isThere() && store_.hasMoved(stage_.robot.joints());
}

/** A repetition finds the scene as the trial did. On the robot it cannot be undone. */
void Trial::armRepeat() noexcept {
  const bool lacks_robot = store_.onRobot() && !stage_.robotJoins();
  if (lacks_robot || hasMoved()) {
    store_.end(lacks_robot ? ExecutionEnd::kRobotLost : ExecutionEnd::kMoved, stage_.thisTick());
    return raise(Event::kReturned);
  }
  stage_.arms.world().restoreScene(scene_);
  rehearses_ = !store_.onRobot();
  raise(Event::kRepeatArmed);
}

}  // namespace raven2_trainer::loop
