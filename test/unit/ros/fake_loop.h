#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "raven2_trainer/loop/shared_state.h"
#include "ros/planning/planning_client.h"

namespace raven2_trainer::ros_bridge {

/** Replaces the physics loop: takes requests and answers as the test wants. A client's pause is one tick. */
class FakeLoop {
 public:
  /** Called for each request. */
  std::function<void(const Request&)> on_request = [](const Request&) {};
  /** Called at the end of each tick, with the tick's number. */
  std::function<void(int)> on_tick = [](int) {};

  void tick() {
    Request request;
    while (shared.requests.tryPop(&request)) {
      seen.push_back(request);
      on_request(request);
    }
    on_tick(++ticks);
    tell();
  }

  void answer(const Request& request, PlanningAnswer answer) { shared.answers.tryPush({request.id, answer}); }

  void tell() {
    ModelState model;
    model.planning = planning;
    model.mode = mode;
    model.view = view;
    shared.model.store(model);
  }

  /** Posts an answer of the planner. */
  void plan(std::uint32_t id, PlanStatus status) {
    PlanResult result;
    result.id = id;
    result.status = status;
    shared.plan_answers.tryPush(result);
  }

  void report(std::uint32_t id, ExecutionEnd end) {
    ExecutionReport result;
    result.id = id;
    result.end = end;
    shared.execution_answers.tryPush(result);
  }

  /** The number of received requests of a kind. */
  int count(RequestKind kind) const {
    int n = 0;
    for (const Request& request : seen)
      n += request.kind == kind ? 1 : 0;
    return n;
  }

  std::unique_ptr<SharedState> state{std::make_unique<SharedState>()};  // 10 MiB
  SharedState& shared{*state};
  PlanningState planning;
  Mode mode{Mode::kPedalUp};
  std::uint8_t view{0};
  std::vector<Request> seen;
  int ticks{0};
};

inline Request requestOf(RequestKind kind) {
  Request request;
  request.kind = kind;
  return request;
}

}  // namespace raven2_trainer::ros_bridge
