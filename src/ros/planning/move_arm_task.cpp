#include "ros/planning/move_arm_task.h"

namespace raven2_trainer::ros_bridge {
namespace {

const char* word(PlanningAnswer answer) {
  return answer == PlanningAnswer::kNone ? "no answer" : kPlanningAnswerNames[static_cast<std::size_t>(answer)];
}

}  // namespace

void MoveArmTask::begin(const Request& request, bool on_robot) {
  outcome_ = {};
  on_robot_ = on_robot;
  phase_ = Phase::kPlanning;
  const PlanningClient::Asked asked = client_.ask(request);
  plan_ = asked.id;
  execution_ = 0;
  if (asked.answer != PlanningAnswer::kAccepted) end(errorCode(asked.answer), word(asked.answer));
}

/** A plan that came meanwhile is not executed any more; how far an execution came is reported. */
void MoveArmTask::cancel() {
  if (isOver()) return;
  const bool is_ours = client_.state().plan == plan_;
  const bool was_taken = !is_ours || client_.cancel().answer == PlanningAnswer::kAccepted;
  if (const std::optional<PlanResult> plan = client_.plan(plan_)) outcome_.plan = *plan;
  if (phase_ == Phase::kExecuting) lookForReport();
  if (!isOver() && !was_taken) end(ErrorCode::kCommunicationFailure, "the cancellation was not answered");
  if (!isOver()) end(ErrorCode::kPreempted, "cancelled");
  outcome_.was_cancelled = outcome_.code != ErrorCode::kSuccess;
}

bool MoveArmTask::look() {
  if (phase_ == Phase::kPlanning) lookForPlan();
  if (phase_ == Phase::kExecuting) lookForReport();
  return isOver();
}

void MoveArmTask::lookForPlan() {
  const std::optional<PlanResult> plan = client_.plan(plan_);
  if (!plan) return;
  outcome_.plan = *plan;
  if (plan->status == PlanStatus::kSuccess) return execute();
  end(errorCode(plan->status), kPlanStatusNames[static_cast<std::size_t>(plan->status)]);
}

void MoveArmTask::execute() {
  Request request;
  request.kind = RequestKind::kExecutePlan;
  request.plan = plan_;
  request.on_robot = on_robot_ ? 1 : 0;
  const PlanningClient::Asked asked = client_.ask(request);
  execution_ = asked.id;
  phase_ = Phase::kExecuting;
  if (asked.answer != PlanningAnswer::kAccepted) end(errorCode(asked.answer), word(asked.answer));
}

void MoveArmTask::lookForReport() {
  const std::optional<ExecutionReport> report = client_.execution(execution_);
  if (!report) return;
  outcome_.report = *report;
  end(errorCode(report->end), kExecutionEndNames[static_cast<std::size_t>(report->end)]);
}

void MoveArmTask::end(ErrorCode code, const std::string& status) {
  phase_ = Phase::kOver;
  outcome_.code = code;
  outcome_.status = status;
}

}  // namespace raven2_trainer::ros_bridge
