#pragma once

#include <cstdint>

namespace raven2_trainer::wire {

/** Rate limit: `burst` at once, `rate` a second in the long run. Knows no clock: time comes in. Whole nanoseconds, so
 *  the same times give the same answers on every machine. Real-time safe. */
class TokenBucket {
 public:
  /** @param[in] rate [1/s] over 0. @param[in] burst [-] at least 1. */
  TokenBucket(double rate, std::int32_t burst) noexcept;

  /** Takes one token. @param[in] now_ns never going back; if it does, no time has passed. @return false without a
   * token. */
  bool take(std::int64_t now_ns) noexcept;

 private:
  std::int64_t interval_ns_;  ///< a token's worth
  std::int64_t capacity_ns_;
  std::int64_t level_ns_;
  std::int64_t last_ns_{0};
};

}  // namespace raven2_trainer::wire
