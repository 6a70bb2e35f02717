#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "raven2_trainer/faults/fault_engine.h"

namespace raven2_trainer::preload {

/** Beginning or end of a fault, on the boards' clock and the computer's. */
struct LoggedChange {
  FaultChange change{};
  std::int64_t time_ns{};   ///< [ns] whatever clock the caller reads
  std::uint32_t command{};  ///< number of the newest packet that had come; 0 none
};

/** Room for all beginnings and ends of one thread's faults: one writer, read at the end. Real-time safe after
 * construction.
 */
class ChangeLog {
 public:
  explicit ChangeLog(std::size_t room = 65536) : changes_(room) {}

  /** Everything that the engine has not reported yet; it is in its cycle `cycle`, counted from 1. */
  void note(faults::FaultEngine* engine, std::uint64_t cycle, std::int64_t time_ns, std::uint32_t command) noexcept {
    LoggedChange next;
    while (engine->nextChange(&next.change)) {
      next.change.cycle = cycle;
      next.time_ns = time_ns;
      next.command = command;
      const std::size_t count = count_.load(std::memory_order_relaxed);
      if (count == changes_.size()) {
        lost_.fetch_add(1, std::memory_order_relaxed);
        continue;
      }
      changes_[count] = next;
      count_.store(count + 1, std::memory_order_release);
    }
  }

  std::size_t size() const noexcept { return count_.load(std::memory_order_acquire); }
  const LoggedChange& operator[](std::size_t i) const noexcept { return changes_[i]; }
  /** Those that had no room. */
  std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  std::vector<LoggedChange> changes_;
  std::atomic<std::size_t> count_{0};
  std::atomic<std::uint64_t> lost_{0};
};

}  // namespace raven2_trainer::preload
