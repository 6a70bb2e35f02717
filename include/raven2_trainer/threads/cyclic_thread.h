#pragma once

#include <pthread.h>
#include <semaphore.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/state_cell.h"
#include "raven2_trainer/threads/runtime_config.h"

namespace raven2_trainer::threads {

/** Settings of a thread before its body runs. */
struct ThreadOptions {
  std::string name;  ///< at most 15 characters
  ThreadConfig scheduling{};
  int nice{0};                   ///< with normal scheduling
  std::size_t stack{1U << 20U};  ///< [bytes] small for loops; the renderer's compiler wants more
};

/** Options of a real-time thread as configured. */
ThreadOptions realtimeThread(const std::string& name, const ThreadConfig& scheduling, const RuntimeConfig& config);

/** Name, priority, affinity of the calling thread. @return 0, or the errno with which SCHED_FIFO was refused. */
int applyThreadOptions(const ThreadOptions& options) noexcept;

/**
 * A thread with an explicit small stack; joined by the destructor. That of a real-time thread is touched to its end
 * before the body runs, so that no page of it is missing later.
 */
class Thread {
 public:
  Thread() = default;
  ~Thread() { join(); }
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  /** Returns once the options are applied. @throw RealtimeException if no thread can be had. */
  void start(const ThreadOptions& options, std::function<void()> body);
  void join();
  /** Gives a nice thread normal priority, where the limits allow it: before a join on a busy machine. */
  void hurry() noexcept;
  /** False if SCHED_FIFO was asked for and refused. */
  bool realtime() const noexcept { return error_.load() == 0; }
  /** "NAME: SCHED_FIFO 80 refused (why)"; empty if it was not refused. */
  std::string refusal() const;

 private:
  static void* entry(void* self) noexcept;
  pthread_t handle_{};
  bool running_{false};
  ThreadOptions options_;
  std::function<void()> body_;
  sem_t ready_{};
  std::atomic<int> error_{0};
  std::atomic<pid_t> id_{0};
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
 *   body     |==>  |==============>|=>=>=>|==>     late: up to `max_catch_up` extra steps a millisecond until caught up
 *
 * Simulated time is never lost, but for a backlog over `max_backlog`, which is counted and reported to `on_slip`.
 * A tick is late if it ends more than 1 ms after its release; late ticks in a row are one event. The thread makes these
 * system calls and no others: clock_nanosleep every millisecond, getrusage every thousandth tick, and those of the
 * body.
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
  std::string refusal() const { return thread_.refusal(); }

 private:
  void run() noexcept;
  std::int64_t catchUp() noexcept;
  std::int64_t giveUp(std::int64_t backlog) noexcept;
  void runTick(std::int64_t release) noexcept;
  void countLateness(std::int64_t late_ns) noexcept;
  void countFaults() noexcept;

  Thread thread_;
  CyclicPolicy policy_;
  Hooks hooks_;
  StateCell<LoopTiming>* timing_{nullptr};
  LoopTiming counts_{};
  std::int64_t release_{0};    // [ns] CLOCK_MONOTONIC, of the oldest tick that is still to run
  std::uint64_t late_run_{0};  // [ticks] late in a row so far
  std::uint64_t first_minor_{0}, first_major_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace raven2_trainer::threads
