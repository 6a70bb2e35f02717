#include "raven2_trainer/wire/token_bucket.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::wire {

TokenBucket::TokenBucket(double rate, std::int32_t burst) noexcept
    : interval_ns_(std::max<std::int64_t>(1, std::llround(1e9 / rate))),
      capacity_ns_(interval_ns_ * std::max(burst, 1)),
      level_ns_(capacity_ns_) {}

bool TokenBucket::take(std::int64_t now_ns) noexcept {
  const std::int64_t passed = std::clamp<std::int64_t>(now_ns - last_ns_, 0, capacity_ns_);
  last_ns_ = std::max(last_ns_, now_ns);
  level_ns_ = std::min(capacity_ns_, level_ns_ + passed);
  if (level_ns_ < interval_ns_) return false;
  level_ns_ -= interval_ns_;
  return true;
}

}  // namespace raven2_trainer::wire
