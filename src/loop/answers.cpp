#include "loop/answers.h"

namespace raven2_trainer::loop {

void Answers::give(std::uint32_t id, PlanningAnswer answer) noexcept {
  if (id == 0 || answer == PlanningAnswer::kNone) return;
  answered_ = id;
  answer_ = answer;
  if (id > kOwnRequestIds) shared_.answers.tryPush({id, answer});
}

void Answers::give(const PlanResult& plan) noexcept {
  shared_.last_plan.store(plan);
  if (plan.id > kOwnRequestIds) shared_.plan_answers.tryPush(plan);
}

void Answers::give(const ExecutionReport& report) noexcept {
  shared_.last_execution.store(report);
  if (report.id > kOwnRequestIds) shared_.execution_answers.tryPush(report);
}

void Answers::show(PlanningState* state) const noexcept {
  state->answered = answered_;
  state->answer = answer_;
}

}  // namespace raven2_trainer::loop
