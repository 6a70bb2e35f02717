#pragma once

#include <cstdint>

namespace raven2_trainer::wire {

/** Sliding window over a 64-bit counter that never wraps, as DTLS has it (RFC 6347, 4.1.2.6): each number once, and
 *  none more than 63 behind the newest. Only for numbers whose origin is proven. Real-time safe. */
class ReplayWindow {
 public:
  static constexpr std::uint64_t kWindow = 64;

  /** Whether this number may be used: not seen, and not behind the window. */
  bool isFresh(std::uint64_t counter) const noexcept;
  /** Older than the newest one marked. */
  bool isLate(std::uint64_t counter) const noexcept { return seen_ != 0 && counter < newest_; }
  /** It is used now. Only after isFresh(). */
  void mark(std::uint64_t counter) noexcept;

  std::uint64_t newest() const noexcept { return newest_; }

 private:
  std::uint64_t newest_{0};
  std::uint64_t seen_{0};  ///< bit k: newest - k was used; 0 before the first
};

}  // namespace raven2_trainer::wire
