#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/impair/impairment.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::lockstep {

/** A session in lockstep: the stack, recorded. The same seed and configuration give the same bytes in the log. */
class Lockstep {
 public:
  /** @throw ModelException, SessionException. `motion` goes into the log's header. */
  Lockstep(const TrainerConfig& config,
           std::unique_ptr<console::MotionSource> source,
           const session::SessionPaths& paths,
           const std::string& motion);
  ~Lockstep();

  /** From now on the link between console and daemon is bad, in both directions and from the configuration's seed. Its
   *  outages are counted from this call. */
  void impair(const Impairment& impairment);

  /** This session is shown before the surgeon begins: LockstepStack::showFirst(). */
  void showFirst(const std::string& session);

  /** When a session ends. */
  enum class End : std::uint8_t {
    kTime,      ///< at its time, whatever the hands do
    kFinished,  ///< or kAfterwards after the hands were finished
    kAtOnce,    ///< or as soon as the hands are finished, however late they begin
  };
  static constexpr Tick kAfterwards = 1000;  ///< [1 ms] what was let go falls and comes to rest

  /**
   * Runs until `seconds` of session time (from the first pedal down).
   * @param[in] progress called about every 100 ms of simulated time with the share done; may be empty.
   * @return false if no pedal-down came within `runtime.start_timeout` of simulated time, what is shown first not
   * counted, or the model's simulation failed.
   */
  bool run(double seconds, const std::function<void(double)>& progress, End end = End::kTime);

  /** Signals for faults' triggers, from the next tick on. */
  void setSignals(const FaultSignals& signals) noexcept;

  /** One tick of everything, for tests. */
  void tick();

  /** Writes footer, metrics.json and faults.json. run() does it itself. */
  void finish();

  /** The state all loops share, for tests. */
  const LockstepView& view() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::lockstep
