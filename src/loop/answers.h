#pragma once

#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** What becomes of requests: each answer goes once through a ring to who asked. The newest also stands in the model's
 *  state, for pictures and the record. One thread; real-time safe. */
class Answers {
 public:
  explicit Answers(SharedState* shared) noexcept : shared_(*shared) {}

  /** To the request with this id. Those of pedals have none, 0, and those of the daemon's own nobody reads. */
  void give(std::uint32_t id, PlanningAnswer answer) noexcept;
  /** A plan that was asked for is there, or is not. */
  void give(const PlanResult& plan) noexcept;
  /** An execution is over. */
  void give(const ExecutionReport& report) noexcept;

  /** Puts the newest into what is told of planning. */
  void show(PlanningState* state) const noexcept;

 private:
  SharedState& shared_;
  std::uint32_t answered_{0};
  PlanningAnswer answer_{PlanningAnswer::kNone};
};

}  // namespace raven2_trainer::loop
