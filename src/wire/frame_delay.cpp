#include "raven2_trainer/wire/frame_delay.h"

#include <algorithm>

namespace raven2_trainer::wire {

std::int64_t FrameDelay::aged(const Low& low, std::int64_t time_ns) noexcept {
  return low.difference + (time_ns - low.at) / kDriftDivisor;
}

void FrameDelay::restart(const Low& first) noexcept {
  has_started_ = true;
  began_ = first.at;
  current_ = previous_ = first;
}

// Within one run of a peer its clock never goes back, so a difference exceeds an earlier one by the time between the
// two receipts at most: nothing here overflows, whatever stamps it sends.
std::int64_t FrameDelay::next(std::uint64_t cycle, std::int64_t time_ns, std::int64_t received_ns) noexcept {
  const Low now{received_ns - time_ns, time_ns};
  if (!has_started_ || cycle < cycle_ || time_ns < time_ns_) restart(now);
  cycle_ = cycle;
  time_ns_ = time_ns;
  if (time_ns - began_ >= kWindowNs / 2) {
    previous_ = current_;
    current_ = now;
    began_ = time_ns;
  }
  if (now.difference <= aged(current_, time_ns)) current_ = now;
  return std::max<std::int64_t>(0, now.difference - std::min(aged(current_, time_ns), aged(previous_, time_ns)));
}

}  // namespace raven2_trainer::wire
