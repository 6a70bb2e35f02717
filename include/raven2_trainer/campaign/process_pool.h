#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "raven2_trainer/campaign/outcome.h"

namespace raven2_trainer::campaign {

constexpr std::size_t kMaxResult =
    1024;  ///< [bytes] of one child; below PIPE_BUF, so that it goes through a pipe whole

/** Limits of a child. */
struct ChildLimits {
  std::int64_t processor{};                     ///< [s] of processor time; more is Ending::kBudget
  std::int64_t wall{};                          ///< [s] since its start, kept by the parent; more is Ending::kNoEnd
  std::size_t memory{std::size_t{512} << 20U};  ///< [bytes] of address space more than it has at its fork
};

/** End of a child. */
struct ChildEnd {
  std::uint64_t tag{};
  Ending ending{Ending::kComplete};
  int signal{};  ///< that killed it, 0 none
  std::array<std::uint8_t, kMaxResult> result{};
};

/**
 * Bodies in forks of this process, some at a time. A body that crashes, throws, ends the process, uses up its time or
 * memory, or stops for good is an ending, not an error. Children die with this process. They see its memory as it was
 * at the fork.
 */
class ProcessPool {
 public:
  /** Writes its result, of a fixed size. */
  using Body = std::function<void(std::uint8_t* result)>;

  /**
   * @param[in] jobs children at a time. @param[in] limits of each child.
   * @param[in] result_size [bytes] of a result. @param[in] report is called at each end, in this process.
   */
  ProcessPool(std::size_t jobs,
              const ChildLimits& limits,
              std::size_t result_size,
              std::function<void(const ChildEnd&)> report);
  /** Kills what still runs. */
  ~ProcessPool();
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  /** Waits for a free place and forks. @throw Exception if this process has other threads, whose locks a fork would
   *  inherit, or if the system refuses. */
  void start(std::uint64_t tag, const Body& body);
  /** Waits until this child has ended. */
  void waitFor(std::uint64_t tag);
  /** Waits until all have. */
  void drain();

 private:
  using Clock = std::chrono::steady_clock;
  struct Child {
    std::uint64_t tag;
    pid_t pid;
    int pipe;
    int process;  ///< readable once it has ended, whatever it did with its pipe
    Clock::time_point deadline;
    bool expired;  ///< killed at its deadline
  };

  [[noreturn]] void runChild(int pipe, pid_t parent, const Body& body) const;
  void reap();
  void waitForEnds();
  int untilFirstDeadline() const;
  void killExpired();
  static bool hasEnded(const Child& child);
  ChildEnd endOf(const Child& child) const;

  std::size_t jobs_;
  ChildLimits limits_;
  std::size_t result_size_;
  std::function<void(const ChildEnd&)> report_;
  std::vector<Child> children_;
};

}  // namespace raven2_trainer::campaign
