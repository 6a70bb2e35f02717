#include "render/plan_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {

namespace {

/** The name of a value as words; ? for one that no log should hold. */
template <std::size_t kCount, typename Value>
std::string words(const std::array<const char*, kCount>& names, Value value) {
  const auto i = static_cast<std::size_t>(value);
  std::string text = i < kCount ? names[i] : "?";
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string armName(Arm arm) {
  return index(arm) < kArmCount ? name(arm) : "?";
}

std::string percent(double share) {
  return std::isfinite(share) ? std::to_string(std::lround(100.0 * std::clamp(share, 0.0, 1.0))) + " %" : "- %";
}

std::string millimetres(double metres) {
  char text[24];
  std::snprintf(text, sizeof text, "%.1f mm", std::min(metres, 9.9) * 1e3);
  return std::isfinite(metres) ? text : "- mm";
}

std::string executionOutcome(const ExecutionReport& report) {
  if (report.end == ExecutionEnd::kFinished) {
    const double model = report.model.at_end, robot = report.on_robot != 0 ? report.robot.at_end : 0.0;
    return "finished, " + millimetres(std::max(model, robot)) + " from the goal";
  }
  const std::string stopped = "stopped: " + words(kExecutionEndNames, report.end);
  return report.started < 0 ? stopped : stopped + " at " + percent(report.progress);
}

/** How the newest plan ended, empty while there is nothing to say. A report of an older plan says nothing any more. */
std::string outcome(const PlanNews& plans) {
  if (!plans.answer) return "";
  const PlanResult& answer = *plans.answer;
  if (answer.status == PlanStatus::kCancelled) return "cancelled";
  if (answer.status != PlanStatus::kSuccess) return "none: " + words(kPlanStatusNames, answer.status);
  const bool has_report = plans.execution && plans.execution->plan == answer.id;
  return has_report ? executionOutcome(*plans.execution) : "";
}

/** Of the plan that is kept. */
std::string readiness(const PlanNews& plans, std::uint32_t plan) {
  const bool has_report = plans.execution && plans.execution->plan == plan;
  return has_report ? executionOutcome(*plans.execution) : "ready";
}

std::string refusal(const PlanningState& state) {
  const bool is_refused = state.answer != PlanningAnswer::kNone && state.answer != PlanningAnswer::kAccepted;
  return is_refused ? "refused: " + words(kPlanningAnswerNames, state.answer) : "";
}

std::string joined(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

std::string whatGoesOn(const Snapshot& snapshot, double path_error) {
  const PlanningState& state = snapshot.model.planning;
  switch (state.status) {
    case PlanningStatus::kIdle:
      return joined(outcome(snapshot.plans), refusal(state));
    case PlanningStatus::kChoosing:
      return "choosing the goal, " + armName(state.arm) + " arm";
    case PlanningStatus::kPlanning:
      return "planning";
    case PlanningStatus::kReady:
      return joined(readiness(snapshot.plans, state.plan), refusal(state));
    case PlanningStatus::kArmed:
      return std::string("ready: hold the pedal, ") + (state.on_robot != 0 ? "robot moves" : "model alone");
    case PlanningStatus::kExecuting:
      return "executing " + percent(state.progress) + "  err " + millimetres(path_error);
  }
  return "?";
}

}  // namespace

double pathError(const ArmGeometry& geometry, const Snapshot& snapshot) noexcept {
  const PlanningState& state = snapshot.model.planning;
  if (state.status != PlanningStatus::kExecuting || index(state.arm) >= kArmCount) return 0.0;
  const ArmState& arm = at(snapshot.model.arms, state.arm);
  const Vector3 path_B = kinematics::forward(geometry, state.arm, arm.q_d).p;
  const double model = (toEigen(arm.p_BT) - path_B).norm();
  if (state.on_robot == 0) return model;
  return std::max(model, (toEigen(at(snapshot.robot.arms, state.arm).p_BT) - path_B).norm());
}

std::string planLine(const Snapshot& snapshot, double path_error) {
  const std::string text = whatGoesOn(snapshot, path_error);
  return text.empty() ? "" : "plan      " + text;
}

}  // namespace raven2_trainer::render
