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

 private:
  void apply(const FaultRequest& request);

  const TrainerConfig& config_;
  SharedState& shared_;
  FaultPlan plan_{};
};

}  // namespace raven2_trainer::runtime
