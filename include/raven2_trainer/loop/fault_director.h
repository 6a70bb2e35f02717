#pragma once

#include "raven2_trainer/faults/fault_library.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/**
 * Body of the faults thread: decides which scenarios are armed. When exactly each acts is in the row itself.
 *
 * A drill is armed for one attempt at a time: with its end what did not come is off, and what acts ends; with the next
 * attempt it is armed again, its jitter drawn again. Once its scenario is cleared or started by request it is over for
 * good.
 */
class FaultDirector {
 public:
  /** Arms config.hazard; as the drill of the first attempt if it is one. */
  FaultDirector(const faults::FaultLibrary& library, SharedState* shared);
  void tick();

  /** Whether there is room for a scenario's plan in addition to the armed ones. */
  static bool fits(const FaultPlan& armed, const FaultPlan& added);

 private:
  void serve(const FaultRequest& request);
  void followAttempts();
  void remove(std::uint32_t id);
  void add(const FaultPlan& added);
  void publish(FaultPlan next);

  const faults::FaultLibrary library_;
  SharedState& shared_;
  FaultPlan plan_{};
  std::uint32_t armings_{0};
  std::uint32_t drill_{0};   ///< id of its scenario; 0: no drill, or it is over
  std::uint8_t attempt_{1};  ///< that the drill is armed for
  std::uint8_t next_{1};     ///< the newest seen
  Tick next_seen_{0};        ///< when that was first seen
};

}  // namespace raven2_trainer::loop
