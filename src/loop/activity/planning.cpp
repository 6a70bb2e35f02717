#include "loop/activity/planning.h"

#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::loop {

using control::Event;

Planning::Planning(const model::RavenModel& raven, const model::SceneModel& scene, Stage* stage)
    : Activity(stage),
      store_(stage->config, raven, scene, &stage->answers, &stage->shared),
      is_scheduled_(stage->config.plan_at >= 0.0) {}

PlanningAnswer Planning::plan(Request request) noexcept {
  const bool is_busy = mode() == Mode::kPlanning || store_.isFull();
  if (!is_busy) raise(Event::kPlanRequested);
  const bool is_refused = is_busy || mode() != Mode::kPlanning;
  if (request.id == 0) request.id = nextOwnId();  // who asked waits for no answer, but the planner's has to be known
  if (is_refused) {
    store_.refuse(request.id, stage_.thisTick());
    return PlanningAnswer::kNotNow;
  }
  store_.ask(request, stage_.arms.joints());
  return PlanningAnswer::kAccepted;
}

/** Each plan has another one than those before it: a late answer to one that was given up is nobody else's. */
std::uint32_t Planning::nextOwnId() noexcept {
  next_id_ = next_id_ < kOwnRequestIds ? next_id_ + 1 : 1;
  return next_id_;
}

void Planning::planBySchedule() noexcept {
  if (!is_scheduled_) return;
  const auto due = toTicks(stage_.config.plan_at);
  if (stage_.state.session_tick < due || mode() != Mode::kPedalUp || stage_.pedal.is_down) return;
  is_scheduled_ = false;
  Request request;
  request.kind = RequestKind::kPlan;
  request.id = nextOwnId();
  stage_.answers.give(request.id, plan(request));
}

void Planning::takeResults() noexcept {
  if (stage_.shared.plan_results.front() == nullptr) return;  // in nearly every tick, and a result is 4 KB to make
  PlanResult result;
  while (stage_.shared.plan_results.tryPop(&result)) {
    const bool is_awaited = store_.isAwaited(result);
    const PlanResult& answer = store_.take(result, stage_.thisTick());
    if (!is_awaited) continue;
    raise(answer.status == PlanStatus::kSuccess ? Event::kPlanReady : Event::kPlanFailed);
    if (mode() == Mode::kTracking) follower_.start(answer);
  }
}

/** Forgets a plan that is no longer shown, computed or chosen. */
void Planning::settle(Mode next, Event /*event*/) noexcept {
  const PlanningStatus status = store_.state().status;
  const bool is_given_up = status == PlanningStatus::kPlanning || status == PlanningStatus::kChoosing;
  if (is_given_up || !traitsOf(next).keeps_plan) store_.forget();
}

/** After a path was shown the model is back on the robot before anything is planned or chosen. */
void Planning::leave(Mode next) noexcept {
  if (mode() != Mode::kTracking) return;
  follower_.stop();
  const bool plans_again = traitsOf(next).seeks != Seeks::kNothing;
  if (plans_again && stage_.robot.isThere()) stage_.arms.join(stage_.robot.joints());
}

void Planning::tick() noexcept {
  if (mode() == Mode::kTracking && follower_.active()) stage_.arms.wantOnPath(follower_.arm(), follower_.tick());
  stage_.increments.drop();
}

void Planning::lead(PerArm<JointArray>* target) noexcept {
  if (mode() != Mode::kTracking || !follower_.active()) return;
  at(*target, follower_.arm()) = stage_.arms.driver().leading(follower_.arm(), follower_.target());
}

}  // namespace raven2_trainer::loop
