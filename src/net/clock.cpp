#include "raven2_trainer/net/clock.h"

#include <ctime>

namespace raven2_trainer::net {

std::int64_t monotonicNow() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace raven2_trainer::net
