#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace raven2_trainer::preload {

/**
 * Data that the program's two threads share: its control thread reads and writes the boards, its network
 * thread receives packets, and faults of both go by both clocks. One writer each, no locks. Real-time safe.
 */
class CycleHistory {
 public:
  static constexpr std::uint64_t kKept = 1U << 17U;  ///< [cycles] 131 s; of older ones the run level is a newer one's

  /** Control thread: a cycle begins. @param[in] run_level that the program went by in the one before. */
  void append(std::uint8_t run_level) noexcept {
    const std::uint64_t number = begun_.load(std::memory_order_relaxed);
    levels_[number % kKept].store(run_level, std::memory_order_relaxed);
    begun_.store(number + 1, std::memory_order_release);
  }
  /** Cycles begun. Any thread. */
  std::uint64_t begun() const noexcept { return begun_.load(std::memory_order_acquire); }
  /** Run level of a cycle below begun(). Any thread. */
  std::uint8_t runLevel(std::uint64_t cycle) const noexcept {
    return levels_[cycle % kKept].load(std::memory_order_relaxed);
  }

  /** Network thread: a packet came. */
  void countPacket(bool pedal_down, std::uint32_t sequence) noexcept {
    newest_command_.store(sequence, std::memory_order_relaxed);
    const std::uint64_t number = packets_.load(std::memory_order_relaxed);
    if (number > 0 || pedal_down) packets_.store(number + 1, std::memory_order_release);
  }
  /** Packets from the first with the pedal down on. Any thread. */
  std::uint64_t packets() const noexcept { return packets_.load(std::memory_order_acquire); }
  /** Sequence number of the newest packet; 0 before the first. Any thread. */
  std::uint32_t newestCommand() const noexcept { return newest_command_.load(std::memory_order_relaxed); }

 private:
  std::array<std::atomic<std::uint8_t>, kKept> levels_{};
  std::atomic<std::uint64_t> begun_{0};
  std::atomic<std::uint64_t> packets_{0};
  std::atomic<std::uint32_t> newest_command_{0};
};

}  // namespace raven2_trainer::preload
