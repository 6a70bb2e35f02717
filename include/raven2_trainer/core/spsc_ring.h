#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/counters.h"

namespace raven2_trainer {

/**
 * Queue of fixed capacity between exactly one producer thread and one consumer thread: keeps every element, in
 * order. When it is full the producer drops the new element and counts it, so nothing is lost silently.
 * Real-time safe on both sides: wait-free, no allocation.
 */
template <typename T, std::size_t Capacity>
class SpscRing {
  static_assert((Capacity & (Capacity - 1)) == 0 && Capacity > 1, "capacity is a power of two");
  static_assert(std::is_trivially_copyable<T>::value, "elements are copied, never destroyed");

 public:
  /** @return false if full; the element is dropped and counted. */
  bool tryPush(const T& element) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == Capacity) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    elements_[tail % Capacity] = element;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /** Consumer: the element that tryPop() would return next; null if empty. */
  const T* front() const noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    return head == tail_.load(std::memory_order_acquire) ? nullptr : &elements_[head % Capacity];
  }

  /** @return false if empty; `*element` is unchanged then. */
  bool tryPop(T* element) noexcept {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    *element = elements_[head % Capacity];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /** Elements dropped because the ring was full, since the start. Any thread. */
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

  /** Counts since the start. Any thread; `taken` is read first, so that it is never above `pushed`. */
  RingCounts counts() const noexcept {
    RingCounts c;
    c.taken = head_.load(std::memory_order_acquire);
    c.pushed = tail_.load(std::memory_order_acquire);
    c.dropped = dropped();
    return c;
  }

 private:
  std::array<T, Capacity> elements_{};
  alignas(64) std::atomic<std::uint64_t> head_{0};
  alignas(64) std::atomic<std::uint64_t> tail_{0};
  alignas(64) std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace raven2_trainer
