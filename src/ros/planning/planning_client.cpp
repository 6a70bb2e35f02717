#include "ros/planning/planning_client.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::uint32_t kFirstId = kOwnRequestIds + 1;
constexpr double kPause = 0.001;     // [s] the loop answers at the end of its tick
constexpr double kAnswerTime = 0.5;  // [s] a loop that was late for longer gives the time up (max_backlog, 0.25 s)
// The loop has dropped the plan and another one's answer stands where its own stood: a cancelled planner takes 100 ms.
constexpr int kLooksForPlan = 250;
constexpr double kGiveUpTime = 0.03;  // [s] so that who cancels has an answer within 100 ms

void sleep() {
  std::this_thread::sleep_for(std::chrono::duration<double>(kPause));
}

/** Above those of a client before: what it was told still stands in the cells. */
std::uint32_t firstId(const SharedState& shared) {
  const std::uint32_t newest =
      std::max({shared.model.load().planning.answered, shared.last_plan.load().id, shared.last_execution.load().id});
  return std::max(kFirstId, newest + 1);
}

/** Something moves at the next pedal-down if it is accepted. */
bool armsSomething(RequestKind kind) {
  return kind == RequestKind::kExecutePlan || kind == RequestKind::kRepeatTrial;
}

bool makesPlan(RequestKind kind) {
  return kind == RequestKind::kPlan || kind == RequestKind::kRecordGoal;
}

}  // namespace

PlanningClient::PlanningClient(SharedState* shared, std::function<void()> pause)
    : shared_(*shared), pause_(std::move(pause)), next_id_(firstId(*shared)) {}

PlanningClient::PlanningClient(SharedState* shared) : PlanningClient(shared, &sleep) {}

bool PlanningClient::post(const Request& request) {
  const std::lock_guard<std::mutex> lock(push_mutex_);
  return shared_.requests.tryPush(request);
}

PlanningClient::Asked PlanningClient::ask(Request request) {
  const std::lock_guard<std::mutex> lock(ask_mutex_);
  request.id = next_id_++;
  Asked asked{request.id, PlanningAnswer::kNone};
  if (!post(request)) return asked;
  await(kAnswerTime, [&] {
    asked.answer = answerTo(request);
    return asked.answer != PlanningAnswer::kNone;
  });
  // Who is told that there was no answer must not find a robot armed by it later. The ring keeps the order.
  if (asked.answer == PlanningAnswer::kNone && armsSomething(request.kind)) postCancel();
  return asked;
}

void PlanningClient::postCancel() {
  Request cancel;
  cancel.kind = RequestKind::kCancelPlan;
  cancel.id = next_id_++;
  post(cancel);
}

/** A plan shows in three places, of which one may be overtaken by what happens next. */
PlanningAnswer PlanningClient::answerTo(const Request& request) const {
  const PlanningState state = this->state();
  if (state.answered == request.id) return state.answer;
  if (!makesPlan(request.kind)) return PlanningAnswer::kNone;
  return state.plan == request.id || plan(request.id) ? PlanningAnswer::kAccepted : PlanningAnswer::kNone;
}

PlanningClient::Cancelled PlanningClient::cancel() {
  const PlanningState before = state();
  Request request;
  request.kind = RequestKind::kCancelPlan;
  const PlanningAnswer answer = ask(request).answer;
  const bool is_at_work = before.status == PlanningStatus::kPlanning && answer == PlanningAnswer::kAccepted;
  return {before.status, answer, !is_at_work || await(kGiveUpTime, [&] { return plan(before.plan).has_value(); })};
}

std::optional<PlanResult> PlanningClient::plan(std::uint32_t id) const {
  const PlanResult newest = shared_.last_plan.load();
  return newest.id == id ? std::optional<PlanResult>(newest) : std::nullopt;
}

std::optional<PlanResult> PlanningClient::awaitPlan(std::uint32_t id, double limit) {
  std::optional<PlanResult> result;
  int in_vain = 0;
  await(limit, [&] {
    result = plan(id);
    in_vain = state().plan == id ? 0 : in_vain + 1;
    return result.has_value() || in_vain > kLooksForPlan;
  });
  return result;
}

std::optional<ExecutionReport> PlanningClient::execution(std::uint32_t id) const {
  const ExecutionReport newest = shared_.last_execution.load();
  return newest.id == id ? std::optional<ExecutionReport>(newest) : std::nullopt;
}

bool PlanningClient::awaitMode(Mode mode) {
  return await(kAnswerTime, [&] { return this->mode() == mode; });
}

PlanningState PlanningClient::state() const {
  return shared_.model.load().planning;
}

Mode PlanningClient::mode() const {
  return shared_.model.load().mode;
}

/** By the number of pauses, and by the clock where pauses are longer than they should be. */
bool PlanningClient::await(double limit, const std::function<bool()>& found) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit);
  const int looks = static_cast<int>(limit / kPause);
  for (int look = 0; look < looks && !stopped_.load(); ++look) {
    if (found()) return true;
    if (std::chrono::steady_clock::now() > deadline) break;
    pause_();
  }
  return !stopped_.load() && found();
}

}  // namespace raven2_trainer::ros_bridge
