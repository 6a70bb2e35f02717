#include "ros/crtk/crtk_lasting.h"

#include <cmath>
#include <iterator>
#include <utility>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kSlowDown = 1.0;  // [s] for an arm to come to rest after a time-out, and for the loop to be late

}  // namespace

CrtkLasting::CrtkLasting(Count count, Find find, double timeout)
    : count_(std::move(count)), find_(std::move(find)), lasts_ns_(std::llround((timeout + kSlowDown) * 1e9)) {}

void CrtkLasting::take(const std::string& topic, std::int64_t now_ns) {
  const auto [found, is_new] = topics_.try_emplace(topic);
  Topic& known = found->second;
  const std::size_t publishers = count_(topic);
  if (is_new || publishers != known.publishers) known.clients.watch(find_(topic));
  known.publishers = publishers;
  known.until_ns = now_ns + lasts_ns_;
}

bool CrtkLasting::hasLost(std::int64_t now_ns) {
  bool has_lost = false;
  for (auto topic = topics_.begin(); topic != topics_.end();) {
    Topic& known = topic->second;
    const bool has_left = known.clients.hasLost(now_ns) || count_(topic->first) < known.publishers;
    has_lost = has_lost || (has_left && now_ns < known.until_ns);
    topic = has_left ? topics_.erase(topic) : std::next(topic);
  }
  for (auto& [name, known] : topics_)
    if (has_lost) known.until_ns = now_ns;
  return has_lost;
}

}  // namespace raven2_trainer::ros_bridge
