#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "raven2_trainer/core/counters.h"

namespace raven2_trainer {

/**
 * Checksum of a record's words and its index. Each step is one-to-one in the word, so it detects every single changed
 * word. It also distinguishes a slot of an earlier lap from a new one. 0.4 us for a tick record.
 */
template <typename T>
std::uint64_t recordChecksum(const T& value, std::uint64_t index) noexcept {
  static_assert(sizeof(T) % sizeof(std::uint64_t) == 0, "read word by word");
  constexpr std::uint64_t kPrime = 0x100000001b3ULL;  // of FNV-1a, 64 bit (RFC 9923)
  std::array<std::uint64_t, sizeof(T) / sizeof(std::uint64_t)> words;
  std::memcpy(words.data(), &value, sizeof(T));
  std::uint64_t hash = 0xcbf29ce484222325ULL ^ index;
  for (const std::uint64_t word : words) {
    hash = (hash ^ word) * kPrime;
    hash ^= hash >> 29U;
  }
  return hash;
}

/**
 * An SpscRing whose memory can outlive the process. Every element carries a checksum. The consumer reads elements with
 * `at`, stores them elsewhere, and only then frees their slots with `release`. Pushed elements that are not released
 * are complete in memory at any instant, so a mapped file keeps them through a SIGKILL. Real-time safe on both sides:
 * wait-free, no allocation, no system call. One producer, one consumer.
 */
template <typename T, std::size_t Capacity>
class RecordRing {
  static_assert(std::is_trivially_copyable<T>::value, "elements are copied, never destroyed");

 public:
  using Element = T;
  static constexpr std::size_t kCapacity = Capacity;
  struct Slot {
    T value{};
    std::uint64_t check{};  ///< recordChecksum(value, index)
  };

  /** Producer. @return false if full; the element is dropped and counted. */
  bool tryPush(const T& element) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == Capacity) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    Slot& slot = slots_[tail % Capacity];
    std::memcpy(&slot.value, &element, sizeof(T));
    // Padding may differ at each read of `element`: compute the checksum from the slot.
    std::atomic_signal_fence(std::memory_order_seq_cst);
    if (has_checks_) slot.check = recordChecksum(slot.value, tail);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /** Before the first push, if the memory ends with the process: leaves out the checksums (for recovery only). */
  void omitChecks() noexcept { has_checks_ = false; }

  /** Producer: also counts elements that were lost before this ring as dropped. */
  void drop(std::uint64_t count) noexcept { dropped_.fetch_add(count, std::memory_order_relaxed); }

  /** Consumer: takes the oldest. @return false if empty; `*element` is unchanged then. */
  bool tryPop(T* element) noexcept {
    const std::uint64_t index = head();
    if (index == tail()) return false;
    *element = at(index);
    release(index + 1);
    return true;
  }

  /** Number of the oldest element in the ring; all below are released. */
  std::uint64_t head() const noexcept { return head_.load(std::memory_order_acquire); }
  /** Number of the next element to be pushed. */
  std::uint64_t tail() const noexcept { return tail_.load(std::memory_order_acquire); }
  /** Consumer: element head() <= index < tail(). */
  const T& at(std::uint64_t index) const noexcept { return slots_[index % Capacity].value; }
  /** Whether the slot contains element `index`, undamaged; for memory from a file. */
  bool isIntact(std::uint64_t index) const noexcept {
    const Slot& slot = slots_[index % Capacity];
    return slot.check == recordChecksum(slot.value, index);
  }
  /** Consumer: frees the slots of all elements below `index`. */
  void release(std::uint64_t index) noexcept { head_.store(index, std::memory_order_release); }

  /** Elements dropped because the ring was full, or by drop(), since the start. Any thread. */
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

  /** Counts since the start. Any thread; `taken` is read first, so that it is never above `pushed`. */
  RingCounts counts() const noexcept {
    RingCounts c;
    c.taken = head();
    c.pushed = tail();
    c.dropped = dropped();
    return c;
  }

  /** Addresses of the parts, to describe the memory. */
  const void* slots() const noexcept { return slots_.data(); }
  const void* tailAddress() const noexcept { return &tail_; }
  const void* droppedAddress() const noexcept { return &dropped_; }

 private:
  std::array<Slot, Capacity> slots_{};
  bool has_checks_{true};
  alignas(64) std::atomic<std::uint64_t> head_{0};
  alignas(64) std::atomic<std::uint64_t> tail_{0};
  alignas(64) std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace raven2_trainer
