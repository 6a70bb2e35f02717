#pragma once

#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** Answers to requests: each goes once through a ring to the client. The newest is also in the model's state, for
 * pictures and the record. One thread; real-time safe. */
class Answers {
 public:
  explicit Answers(SharedState* shared) noexcept : shared_(*shared) {}

  /** To the request with this id. Requests of pedals have the id 0. Nobody reads answers to the daemon's requests. */
  void give(std::uint32_t id, PlanningAnswer answer) noexcept;
  /** A plan that was asked for is there, or is not. */
  void give(const PlanResult& plan) noexcept;
  /** An execution is over. */
  void give(const ExecutionReport& report) noexcept;

  /** Writes the newest answer into `state`. */
  void show(PlanningState* state) const noexcept;

 private:
  SharedState& shared_;
  std::uint32_t answered_{0};
  PlanningAnswer answer_{PlanningAnswer::kNone};
};

}  // namespace raven2_trainer::loop
