#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/fault.h"

namespace raven2_trainer::faults {

/**
 * Applies the faults of one host, tick by tick. With an empty plan every apply is the identity.
 *
 * Ticks count the host's cycles since the first pedal-down cycle it saw. A fault is due at `first_tick` and then every
 * `period_ticks`; when it is due with the pedal up it waits for the next pedal-down cycle, and then stays active for
 * exactly `duration_ticks` cycles. Real-time safe.
 */
class FaultEngine {
 public:
  explicit FaultEngine(FaultHost host) noexcept : host_(host) {}

  /** Takes over a plan if its generation is new: faults that stay keep their progress. */
  void setPlan(const FaultPlan& plan) noexcept;

  /** Once a cycle, before any apply. */
  void beginCycle(bool pedal_down) noexcept;

  /** Value of one variable after the faults of that site. `joint` is a Joint or, for increments, an ITP axis. */
  double apply(FaultSite site, FaultTarget target, Arm arm, int joint, double value) noexcept;

  /** Applies increment and pedal faults of kNetworkLayer to a command. */
  void applyToCommand(MasterCommand* command) noexcept;

  /** Id of the first active fault, 0 if none. */
  std::uint32_t activeId() const noexcept;

  /** Cycles since the first pedal-down cycle; -1 before it. */
  std::int64_t tick() const noexcept { return tick_; }

 private:
  static constexpr std::size_t kChannels = kArmCount * kJointCount;

  struct Progress {
    std::int64_t next{};   ///< tick at which it is due
    std::int64_t end{-1};  ///< first tick after the present activation; -1 idle
    std::int64_t times{};  ///< activations so far
    bool active{};
    std::array<double, kChannels> held{};  ///< kHoldLast: last value before the fault
  };

  bool concerns(const Fault& fault, FaultSite site, FaultTarget target, Arm arm, int joint) const noexcept;
  void advance(const Fault& fault, Progress* progress, bool pedal_down) const noexcept;

  FaultHost host_;
  FaultPlan plan_{};
  std::array<Progress, kMaxFaults> progress_{};
  std::int64_t tick_{-1};
};

}  // namespace raven2_trainer::faults
