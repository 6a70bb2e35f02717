#include "render/session_clock.h"

#include <algorithm>
#include <iterator>

namespace raven2_trainer::render {

void SessionClock::add(const ModelState& model) {
  const Tick now = model.session_tick;
  if (now < 0) return;
  if (stretches_.empty() || at(model.tick) != now) stretches_.push_back({model.tick, now, now == last_});
  last_ = now;
}

Tick SessionClock::at(Tick tick) const {
  const auto behind = std::upper_bound(stretches_.begin(), stretches_.end(), tick,
                                       [](Tick value, const Stretch& stretch) { return value < stretch.tick; });
  if (behind == stretches_.begin()) return -1;
  const Stretch& stretch = *std::prev(behind);
  return stretch.session_tick + (stretch.is_paused ? 0 : tick - stretch.tick);
}

}  // namespace raven2_trainer::render
