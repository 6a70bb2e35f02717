#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/record.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::daemon {

/**
 * The two 1 kHz loops of the daemon with their own threads, driven by a simple motion instead of sockets. Both arms
 * press on the scene and lift, with a clutch now and then. They are linked to a made-up robot that lags some
 * millimetres behind, so contacts, relay, force and records all have work. A third thread, woken like the daemon's
 * sender, takes their packets and records. For timing measurements: the load is that of a session.
 */
class DrivenLoops {
 public:
  /** @throw ModelException. ODE must be initialised. */
  explicit DrivenLoops(const TrainerConfig& config);
  ~DrivenLoops();
  DrivenLoops(const DrivenLoops&) = delete;
  DrivenLoops& operator=(const DrivenLoops&) = delete;

  /** Called on the thread at the start of each tick, with the number of ticks before it; before start(). */
  std::function<void(LoopId loop, std::uint64_t tick)> observer;

  /** @throw RealtimeException if no thread can be had. */
  void start();
  void stop();
  LoopTiming timing(LoopId loop) const noexcept;

  // The bodies, for callers without threads.
  void physicsTick(std::int64_t now_ns) noexcept;
  void hapticTick(std::int64_t now_ns) noexcept;
  /** Takes what was sent and recorded, as a sender and a recorder would. */
  void drain() noexcept;

  ModelState model() const noexcept;
  /** For requests, and what else may come in addition to the motion: from the physics thread, where the observer is. */
  SharedState& shared() noexcept;
  HapticState haptic() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Threads of the same priorities on the same cpus with nothing to do: what this machine can keep at this moment. */
class BareLoops {
 public:
  explicit BareLoops(const TrainerConfig& config);
  ~BareLoops();
  void start();
  void stop();
  LoopTiming timing(LoopId loop) const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::daemon
