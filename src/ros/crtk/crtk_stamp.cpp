#include "ros/crtk/crtk_stamp.h"

#include <limits>

#include "raven2_trainer/net/clock.h"
#include "ros/bridge/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int64_t kApart = 200'000;  // [ns] a tenth of CrtkConfig::period: then stamps keep their order
constexpr int kTries = 5;
const ros::Duration kNext(0, 1'000);  // a float64 in seconds, as Python has it, resolves 0.24 us
const ros::Duration kSetBack(1, 0);   // more than a shift between the clocks: somebody has set one

}  // namespace

CrtkMoment momentOf(const std::function<std::int64_t()>& monotonic, const std::function<ros::Time()>& ros) {
  CrtkMoment best;
  std::int64_t apart = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kTries && apart > kApart; ++i) {
    const std::int64_t before = monotonic();
    const ros::Time now = ros();
    const std::int64_t gap = monotonic() - before;
    if (gap >= apart) continue;
    apart = gap;
    best = {before + gap / 2, now};
  }
  return best;
}

CrtkMoment momentNow() {
  return momentOf(&net::monotonicNow, &ros::Time::now);
}

ros::Time CrtkStamp::of(std::int64_t then_ns, const CrtkMoment& now) {
  const ros::Time stamp = stampOf(then_ns, now.monotonic_ns, now.ros);
  const bool goes_on = stamp > last_ || last_ - stamp > kSetBack;
  last_ = goes_on ? stamp : last_ + kNext;
  return last_;
}

}  // namespace raven2_trainer::ros_bridge
