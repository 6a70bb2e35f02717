#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::faults {

#ifdef RAVEN2_TRAINER_WITHOUT_FAULT_HOOKS
constexpr bool kHasHooks = false;  ///< for the test that hooks change nothing
#else
constexpr bool kHasHooks = true;
#endif

/** Data of one cycle for triggers. */
struct FaultCycle {
  bool pedal_down{};
  int run_level{-1};  ///< -1 unknown to this host
  FaultSignals signals{};
};

/**
 * Applies the faults of one host, tick by tick. An apply on a variable without a row costs one branch.
 *
 * Each fault's clock runs from its trigger (FaultTrigger). It is due at `first_tick` and then every `period_ticks`;
 * with trigger pedal_down or step, when it is due with the pedal up, it waits for the next pedal-down cycle. Then it
 * lasts for exactly `duration_ticks` cycles, or packets (lastsForPackets()). Draws come from each fault's own seed.
 *
 * Every beginning and end is reported once, in order (nextChange()). Real-time safe.
 */
class FaultEngine {
 public:
  explicit FaultEngine(FaultHost host) noexcept : host_(host) {}

  /** Takes over a plan if its generation is new. Faults that stay keep their progress. Another session's plan restarts
   *  everything, also the clocks of pedal and packets. With a suspended plan the present faults stay, and none acts. */
  void setPlan(const FaultPlan& plan) noexcept;

  /** Once a cycle, before any apply. */
  void beginCycle(const FaultCycle& cycle) noexcept;
  /** Once a packet, before any apply to it. */
  void beginPacket(bool pedal_down) noexcept;

  /** While held, no fault acts, but clocks run on: a fault that is due meanwhile acts only for the time then left. */
  void hold(bool is_held) noexcept;
  bool isHeld() const noexcept { return held_; }

  /** Whether faults of this host are armed and may act. */
  bool isArmed() const noexcept { return kHasHooks && armed_; }

  /** The oldest unreported beginning or end; the host sets `cycle`, by its clock. @return false without
   * one. Beyond kMaxChanges unread ones, the newest are lost. */
  bool nextChange(FaultChange* change) noexcept;
  /** Number of changes that were lost because the host did not read them. */
  std::uint64_t changesUnreported() const noexcept { return number_ - changes_begun_; }

  /** One element of a variable after its faults. `arm` is ignored for a variable without arms. */
  double apply(FaultVariable variable, Arm arm, std::size_t channel, double value) noexcept {
    return hasRow(variable) ? corrupt(variable, arm, channel, value) : value;
  }
  /** The same for whole numbers of the robot's program: rounded, at the ends of int32 saturated; NaN gives 0. */
  std::int32_t applyInt(FaultVariable variable, Arm arm, std::size_t channel, std::int32_t value) noexcept;
  /** Every element of an array. */
  template <typename Array>
  void applyAll(FaultVariable variable, Arm arm, Array* values) noexcept {
    if (!hasRow(variable)) return;
    for (std::size_t i = 0; i < values->size(); ++i)
      (*values)[i] = corrupt(variable, arm, i, (*values)[i]);
  }

  /** The fault of such a kind that acts on a stream or program now; null if none does. */
  const Fault* acting(FaultVariable variable, FaultKind kind) const noexcept;

  /** Uniform in [0, 1) from the seed of an acting fault. */
  double draw(const Fault& fault) noexcept;

  /** Id of the first active fault, 0 if none. */
  std::uint32_t activeId() const noexcept;
  /** Bit i: row i of the plan acts in this cycle. */
  std::uint8_t activeMask() const noexcept;

  /** Cycles since the first pedal-down cycle; -1 before it. */
  std::int64_t tick() const noexcept { return tick_; }
  /** Number of the cycle, from 0. */
  std::int64_t cycle() const noexcept { return cycle_; }

 private:
  static constexpr std::size_t kChannels = kArmCount * kMaxFaultChannels;

  struct Element {
    double last{};              ///< before the activation
    double onset{};             ///< at its first tick
    double drawn{};             ///< for the activation
    std::int64_t of{-1};        ///< activation that `onset` belongs to
    std::int64_t drawn_of{-1};  ///< that `drawn` belongs to
    bool seen{};
  };

  struct Progress {
    std::int64_t clock{-1};  ///< -1: the trigger has not come
    std::int64_t next{};     ///< tick at which it is due
    std::int64_t age{};      ///< [ticks] of the present activation
    std::int64_t times{};    ///< times it was due
    std::int64_t activations{};
    std::uint32_t tool_changes{};  ///< when it was first looked at
    bool looked_at{};
    bool active{};
    Random random{0};
    std::array<Element, kChannels> elements{};
  };

  static constexpr std::size_t kMaxChanges = 64;  ///< unread ones of a host: each row begins and ends four times

  /** Whether corrupt() can do anything. Most variables have no row in the plan. */
  bool hasRow(FaultVariable variable) const noexcept {
    return isArmed() && (variables_ >> static_cast<unsigned>(variable) & 1U) != 0;
  }
  void start(const Fault& fault, Progress* progress) const noexcept;
  void takeOver(const FaultPlan& plan) noexcept;
  void rearm() noexcept;
  void report(const Fault& fault, std::uint32_t session, bool acts) noexcept;
  double corrupt(FaultVariable variable, Arm arm, std::size_t channel, double value) noexcept;
  double corrupted(const Fault& fault, Progress* progress, const Element& element, double value) noexcept;
  bool concerns(const Fault& fault, FaultVariable variable, Arm arm, std::size_t channel) const noexcept;
  bool isActing(const Fault& fault, const Progress& progress) const noexcept;
  std::int64_t clockOf(const Fault& fault, const Progress& progress, const FaultCycle& cycle) const noexcept;
  void advance(const Fault& fault, Progress* progress, bool may_start) noexcept;
  void end(const Fault& fault, Progress* progress) noexcept;

  FaultHost host_;
  bool armed_{false};
  bool held_{false};
  FaultPlan plan_{};
  std::uint64_t variables_{0};  ///< bit i: a row of this host is on variable i
  static_assert(kFaultVariableCount <= 64);
  std::array<Progress, kMaxFaults> progress_{};
  std::array<FaultChange, kMaxChanges> changes_{};
  std::uint64_t number_{0};  ///< of the newest change
  std::uint64_t changes_begun_{0}, changes_published_{0};
  std::int64_t cycle_{-1};
  std::int64_t tick_{-1};
  std::int64_t packet_{-1};
};

}  // namespace raven2_trainer::faults
