#pragma once

#include <cstdint>

namespace raven2_trainer::wire {

/**
 * The delay of each frame of a peer, although the two clocks are independent. It is the frame's receipt by our
 * clock minus its stamp by the peer's, above the smallest such difference of late (sources.md 2.2). So a
 * frame that waited in some buffer is known to be old when it arrives.
 *
 * The smallest difference is kept over the last 5 to 10 s of the *peer's* clock. So a silence changes it only by
 * ageing. A peer whose clock stopped (a suspended computer) is trusted again 10 s later. The difference ages by 200
 * ppm, the largest drift of two quartz clocks, so drift is never taken for delay. The estimate can therefore be too
 * small by as much as 4 ms (200 ppm each way over 10 s; more for the first frames behind a longer silence), and by the
 * delay of the fastest frame, which is unknown. Real-time safe.
 */
class FrameDelay {
 public:
  static constexpr std::int64_t kWindowNs = 10'000'000'000;                   ///< [ns] of the peer's clock, at most
  static constexpr std::int64_t kDriftDivisor = 5000;                         ///< 1 / 200 ppm
  static constexpr std::int64_t kMaxErrorNs = 2 * kWindowNs / kDriftDivisor;  ///< [ns] too small by this at most

  /**
   * Delay of the peer's next frame. A peer whose cycle or clock went back started again: its first delay is 0.
   * @param[in] cycle the peer's number of the frame.
   * @param[in] time_ns [ns] its stamp by the peer's clock, not negative.
   * @param[in] received_ns [ns] our monotonic clock, not negative.
   * @return [ns] not negative; 0 for the quickest frame.
   */
  std::int64_t next(std::uint64_t cycle, std::int64_t time_ns, std::int64_t received_ns) noexcept;

 private:
  /** The smallest difference of a part of the window. */
  struct Low {
    std::int64_t difference{0};  ///< [ns] receipt less stamp
    std::int64_t at{0};          ///< [ns] the peer's clock then
  };

  static std::int64_t aged(const Low& low, std::int64_t time_ns) noexcept;
  void restart(const Low& first) noexcept;

  bool has_started_{false};
  std::uint64_t cycle_{0};
  std::int64_t time_ns_{0};
  std::int64_t began_{0};  ///< [ns] the peer's clock when `current_` was begun
  Low current_, previous_;
};

}  // namespace raven2_trainer::wire
