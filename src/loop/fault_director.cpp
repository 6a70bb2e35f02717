#include "raven2_trainer/loop/fault_director.h"

#include "raven2_trainer/faults/arming.h"

namespace raven2_trainer::loop {

FaultDirector::FaultDirector(const faults::FaultLibrary& library, SharedState* shared)
    : library_(library),
      shared_(*shared),
      drill_(faults::isDrill(library_) ? faults::idOf(library_.scenarios, library_.drill) : 0) {
  plan_ = drill_ != 0 ? faults::drillPlan(library_, attempt_, 1)
                      : faults::planFor(library_, faults::idOf(library_.scenarios, library_.hazard), 1);
  shared_.faults.store(plan_);
}

void FaultDirector::tick() {
  FaultRequest request;
  while (shared_.fault_requests.tryPop(&request))
    serve(request);
  if (drill_ != 0) followAttempts();
}

void FaultDirector::serve(const FaultRequest& request) {
  if (request.fault_id == 0 || request.fault_id == drill_) drill_ = 0;
  remove(request.fault_id);
  if (request.order == FaultOrder::kArm) add(faults::planFor(library_, request.fault_id, 0));
  if (request.order == FaultOrder::kArmAtOnce) add(faults::immediatePlan(library_, request.fault_id, 0));
}

/** In an attempt's first tick, triggers would see data of the attempt before. So the fault is armed a tick later. */
void FaultDirector::followAttempts() {
  const ModelState model = shared_.model.load();
  const ExerciseState& exercise = model.exercise;
  if (exercise.attempt == 0) return;
  if (exercise.attempt != next_) {
    next_ = exercise.attempt;
    next_seen_ = model.tick;
  }
  const bool is_over = exercise.status == ExerciseStatus::kDone || exercise.status == ExerciseStatus::kFailed;
  if (is_over || next_ != attempt_) remove(drill_);
  if (next_ == attempt_ || model.tick <= next_seen_) return;
  attempt_ = next_;
  add(faults::drillPlan(library_, attempt_, 0));
}

void FaultDirector::remove(std::uint32_t id) {
  FaultPlan next = plan_;
  next.count = 0;
  for (std::size_t i = 0; i < plan_.count; ++i) {
    const bool goes = id == 0 || plan_.faults[i].id == id;
    if (!goes) next.faults[next.count++] = plan_.faults[i];
  }
  if (next.count != plan_.count) publish(next);
}

/** Arms all rows of a scenario, or none if they do not fit. */
void FaultDirector::add(const FaultPlan& added) {
  if (added.count == 0 || !fits(plan_, added)) return;
  FaultPlan next = plan_;
  ++armings_;
  for (std::size_t i = 0; i < added.count; ++i) {
    next.faults[next.count] = added.faults[i];
    next.faults[next.count++].arming = armings_;
  }
  publish(next);
}

void FaultDirector::publish(FaultPlan next) {
  next.generation = plan_.generation + 1;
  plan_ = next;
  shared_.faults.store(plan_);
}

bool FaultDirector::fits(const FaultPlan& armed, const FaultPlan& added) {
  std::size_t count = added.count;
  for (std::size_t i = 0; i < armed.count; ++i)
    count += armed.faults[i].id == added.faults[0].id ? 0 : 1;  // its own former rows go first
  return count <= kMaxFaults;
}

}  // namespace raven2_trainer::loop
