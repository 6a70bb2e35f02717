#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "raven2_trainer/campaign/outcome.h"

namespace raven2_trainer::campaign {

constexpr std::size_t kMaxResult =
    1024;  ///< [bytes] of one child; below PIPE_BUF, so that it goes through a pipe whole

/** What a child ended with. */
struct ChildEnd {
  std::uint64_t tag{};
  Ending ending{Ending::kComplete};
  int signal{};  ///< that killed it, 0 none
  std::array<std::uint8_t, kMaxResult> result{};
};

/**
 * Bodies in forks of this process, some at a time. A body that crashes, throws, ends the process or uses up its time is
 * an ending, not an error. Children die with this process. They see its memory as it was at the fork.
 */
class ProcessPool {
 public:
  /** Writes its result, of a fixed size. */
  using Body = std::function<void(std::uint8_t* result)>;

  /**
   * @param[in] jobs children at a time. @param[in] cpu_limit [s] of processor time a child may take.
   * @param[in] result_size [bytes] of a result. @param[in] report is told of each end, in this process.
   */
  ProcessPool(std::size_t jobs,
              std::int64_t cpu_limit,
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
  struct Child {
    std::uint64_t tag;
    pid_t pid;
    int pipe;
  };

  [[noreturn]] void runChild(int pipe, pid_t parent, const Body& body) const;
  void reap();
  ChildEnd endOf(const Child& child) const;

  std::size_t jobs_;
  std::int64_t cpu_limit_;
  std::size_t result_size_;
  std::function<void(const ChildEnd&)> report_;
  std::vector<Child> children_;
};

}  // namespace raven2_trainer::campaign
