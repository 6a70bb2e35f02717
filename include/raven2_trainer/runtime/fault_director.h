#pragma once

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"

namespace raven2_trainer::runtime {

/** Body of the faults thread: decides which scenarios are armed. When exactly each acts is in the row itself. */
class FaultDirector {
 public:
  /** Arms config.hazard. */
  FaultDirector(const TrainerConfig& config, SharedState* shared);
  void tick();

  /** Whether there is room for a scenario's plan beside what is armed. */
  static bool fits(const FaultPlan& armed, const FaultPlan& added);

 private:
  void remove(std::uint32_t id);
  void add(std::uint32_t id);
  void publish(FaultPlan next);

  const TrainerConfig& config_;
  SharedState& shared_;
  FaultPlan plan_{};
  std::uint32_t armings_{0};
};

}  // namespace raven2_trainer::runtime
