#include "ros/planning/planning_client.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::size_t kKept = 12;     // of a kind: a waiting call looks every millisecond
constexpr double kPause = 0.001;      // [s] the loop answers at the end of its tick
constexpr double kAnswerTime = 0.5;   // [s] a loop that was late for longer gives the time up (max_backlog, 0.25 s)
constexpr double kGiveUpTime = 0.03;  // [s] so that who cancels has an answer within 100 ms

void sleep() {
  std::this_thread::sleep_for(std::chrono::duration<double>(kPause));
}

/** Something moves at the next pedal-down if it is accepted. */
bool armsSomething(RequestKind kind) {
  return kind == RequestKind::kExecutePlan || kind == RequestKind::kRepeatTrial;
}

}  // namespace

PlanningClient::PlanningClient(SharedState* shared, std::function<void()> pause)
    : shared_(*shared), pause_(std::move(pause)) {}

PlanningClient::PlanningClient(SharedState* shared) : PlanningClient(shared, &sleep) {}

bool PlanningClient::post(const Request& request) {
  const std::lock_guard<std::mutex> lock(push_mutex_);
  return shared_.requests.tryPush(request);
}

/** Keeps the newest ones of any id: a plan may take longer than a dozen requests after it. */
template <typename Ring, typename Answer>
std::optional<Answer> PlanningClient::find(Ring* ring, std::deque<Answer>* kept, std::uint32_t id) {
  const std::lock_guard<std::mutex> lock(answers_mutex_);
  Answer answer;
  while (ring->tryPop(&answer)) {
    kept->push_back(answer);
    if (kept->size() > kKept) kept->pop_front();
  }
  const auto found = std::find_if(kept->begin(), kept->end(), [id](const Answer& each) { return each.id == id; });
  return found == kept->end() ? std::nullopt : std::optional<Answer>(*found);
}

PlanningClient::Asked PlanningClient::ask(Request request) {
  bool is_posted = false;
  const Asked asked = askBy([&](std::uint32_t id) {
    request.id = id;
    plan(id);  // so that the rings have room for what comes of it
    execution(id);
    is_posted = post(request);
    return is_posted;
  });
  // A client that got no answer must not find a robot armed by it later. The ring keeps the order.
  if (is_posted && asked.answer == PlanningAnswer::kNone && armsSomething(request.kind)) postCancel();
  return asked;
}

PlanningClient::Asked PlanningClient::askBy(const std::function<bool(std::uint32_t id)>& send) {
  Asked asked{shared_.next_request.fetch_add(1), PlanningAnswer::kNone, Mode::kWaiting};
  if (!send(asked.id)) return asked;
  await(kAnswerTime, [&] {
    const auto found = find(&shared_.answers, &answers_, asked.id);
    if (found) asked = {found->id, found->answer, found->mode};
    return found.has_value();
  });
  return asked;
}

void PlanningClient::postCancel() {
  Request cancel;
  cancel.kind = RequestKind::kCancelPlan;
  post(cancel);
}

PlanningClient::Cancelled PlanningClient::cancel() {
  const PlanningState before = state();
  Request request;
  request.kind = RequestKind::kCancelPlan;
  const PlanningAnswer answer = ask(request).answer;
  const bool is_at_work = before.status == PlanningStatus::kPlanning && answer == PlanningAnswer::kAccepted;
  return {before.status, answer, !is_at_work || await(kGiveUpTime, [&] { return plan(before.plan).has_value(); })};
}

std::optional<PlanResult> PlanningClient::plan(std::uint32_t id) {
  return find(&shared_.plan_answers, &plans_, id);
}

std::optional<PlanResult> PlanningClient::awaitPlan(std::uint32_t id, double limit) {
  std::optional<PlanResult> result;
  await(limit, [&] {
    result = plan(id);
    return result.has_value();
  });
  return result;
}

std::optional<ExecutionReport> PlanningClient::execution(std::uint32_t id) {
  return find(&shared_.execution_answers, &executions_, id);
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
