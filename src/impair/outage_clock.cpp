#include "raven2_trainer/impair/outage_clock.h"

#include <algorithm>
#include <cmath>

#include "impair/generator.h"

namespace raven2_trainer::impair {

OutageClock::OutageClock(const Impairment& impairment, std::uint64_t seed, std::uint64_t stream, std::int64_t start_ns)
    : cuts_(impairment.cuts), script_(impairment.outages), random_(generator(seed, stream)), start_ns_(start_ns) {
  from_ns_ = cuts_.first_ns;
  to_ns_ = from_ns_ + drawLength();
}

std::int64_t OutageClock::cutUntil(std::int64_t now_ns) noexcept {
  const std::int64_t time = now_ns - start_ns_;
  std::int64_t until = time;
  while (cuts_.longest_ns > 0 && time >= to_ns_) {
    from_ns_ = to_ns_ + cuts_.pause_ns;
    to_ns_ = from_ns_ + drawLength();
  }
  if (cuts_.longest_ns > 0 && time >= from_ns_) until = to_ns_;
  for (const Outage& outage : script_) {
    if (time >= outage.from_ns && time < outage.to_ns) until = std::max(until, outage.to_ns);
  }
  return start_ns_ + until;
}

std::int64_t OutageClock::drawLength() noexcept {
  const double length = random_.uniform(static_cast<double>(cuts_.shortest_ns), static_cast<double>(cuts_.longest_ns));
  return std::max<std::int64_t>(std::llround(length), 1);  // never none: the loop above must come to an end
}

}  // namespace raven2_trainer::impair
