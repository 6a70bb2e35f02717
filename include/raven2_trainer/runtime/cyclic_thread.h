#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/state_cell.h"

namespace raven2_trainer::runtime {

/** What a thread is given before its body runs. */
struct ThreadOptions {
  std::string name;  ///< at most 15 characters
  ThreadConfig scheduling{};
  int nice{0};                   ///< with normal scheduling
  std::size_t stack{1U << 20U};  ///< [bytes] small for loops; the renderer's compiler wants more
};

/** Name, priority, affinity of the calling thread. @return true unless SCHED_FIFO was asked for and refused. */
bool applyThreadOptions(const ThreadOptions& options) noexcept;

/** Locks memory where the limits allow it. @return in words what was got, for the session and the diagnostics. */
std::string lockMemory();

/** A thread with an explicit small stack; joined by the destructor. */
class Thread {
 public:
  Thread() = default;
  ~Thread() { join(); }
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  /** @throw RealtimeException if no thread can be had. */
  void start(const ThreadOptions& options, std::function<void()> body);
  void join();
  /** Gives a nice thread normal priority, where the limits allow it: for who is about to join it on a busy machine. */
  void hurry() noexcept;
  /** False if SCHED_FIFO was asked for and refused; valid once the body runs. */
  bool realtime() const noexcept { return realtime_.load(); }

 private:
  static void* entry(void* self) noexcept;
  pthread_t handle_{};
  bool running_{false};
  ThreadOptions options_;
  std::function<void()> body_;
  std::atomic<bool> realtime_{true};
  std::atomic<pid_t> id_{0};  ///< once the body runs
};

/** Overrun policy of a cyclic thread. */
struct CyclicPolicy {
  int max_catch_up{4};            ///< [ticks] extra steps a tick when behind
  std::int64_t max_backlog{250};  ///< [ticks] more is given up, as a time-slip event
};

/**
 * Calls a body every millisecond of CLOCK_MONOTONIC, by absolute releases:
 *
 *   release  |     |     |     |     |     |
 *   body     |==>  |==============>|=>=>=>|==>     late: up to `max_catch_up` extra steps a tick until caught up
 *
 * Simulated time is never lost, but for a backlog over `max_backlog`, which is counted and told to `on_slip`.
 */
class CyclicThread {
 public:
  struct Hooks {
    std::function<void()> before;                   ///< on the thread, may allocate
    std::function<void(std::int64_t now_ns)> tick;  ///< real-time safe
    std::function<void()> on_slip;                  ///< real-time safe; may be empty
    std::function<std::uint64_t()> stale_reads;     ///< for LoopTiming; may be empty
  };

  ~CyclicThread() { stop(); }
  /** `timing` gets the figures, every tick; the thread is its one writer. */
  void start(const ThreadOptions& options, const CyclicPolicy& policy, Hooks hooks, StateCell<LoopTiming>* timing);
  void stop();
  bool realtime() const noexcept { return thread_.realtime(); }

 private:
  void run() noexcept;
  std::int64_t catchUp(std::int64_t release) noexcept;
  void runTick(std::int64_t release) noexcept;

  Thread thread_;
  CyclicPolicy policy_;
  Hooks hooks_;
  StateCell<LoopTiming>* timing_{nullptr};
  LoopTiming counts_{};
  std::atomic<bool> stop_{false};
};

}  // namespace raven2_trainer::runtime
