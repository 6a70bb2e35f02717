#pragma once

#include "raven2_trainer/faults/fault_library.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/**
 * Body of the faults thread: decides which scenarios are armed. A fault's row determines when it acts.
 *
 * A drill's scenario is armed per attempt. The attempt's end cancels faults that have not begun, and stops those that
 * act. The next attempt arms it again with a new jitter. A request that clears or starts its scenario ends the drill
 * for good.
 */
class FaultDirector {
 public:
  /** Arms the drill's scenario for the first attempt; without a drill, library.hazard. */
  FaultDirector(const faults::FaultLibrary& library, SharedState* shared);
  void tick();
  /** Faults that are armed from now on draw from this seed instead of the configuration's. */
  void reseed(std::uint64_t seed) noexcept { library_.seed = seed; }

  /** Whether a scenario's plan fits in addition to the armed ones. */
  static bool fits(const FaultPlan& armed, const FaultPlan& added);

 private:
  void serve(const FaultRequest& request);
  void followAttempts();
  void remove(std::uint32_t id);
  void add(const FaultPlan& added);
  void publish(FaultPlan next);

  faults::FaultLibrary library_;
  SharedState& shared_;
  FaultPlan plan_{};
  std::uint32_t armings_{0};
  std::uint32_t drill_{0};   ///< id of its scenario; 0: no drill, or it is over
  std::uint8_t attempt_{1};  ///< attempt for which the drill is armed
  std::uint8_t next_{1};     ///< newest attempt seen
  Tick next_seen_{0};        ///< tick in which it was first seen
};

}  // namespace raven2_trainer::loop
