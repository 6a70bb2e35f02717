#include "raven2_trainer/control/path_follower.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::control {
namespace {

// Largest values over [0, 1] of the first two derivatives of 10s^3 - 15s^4 + 6s^5: 30s^2(1-s)^2 at s = 1/2 and
// 60s(1-s)(1-2s) at s = 1/2 - sqrt(3)/6.
constexpr double kPeakVelocity = 15.0 / 8.0;
const double kPeakAcceleration = 10.0 / std::sqrt(3.0);

}  // namespace

double quinticDuration(const JointArray& delta,
                       const JointArray& velocity_limit,
                       const JointArray& acceleration_limit) noexcept {
  double duration = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double distance = std::abs(delta[j]);
    duration = std::max({duration, kPeakVelocity * distance / velocity_limit[j],
                         std::sqrt(kPeakAcceleration * distance / acceleration_limit[j])});
  }
  return duration;
}

double quinticBlend(double s) noexcept {
  const double x = std::clamp(s, 0.0, 1.0);
  return x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
}

void PathFollower::start(const PlanResult& plan) noexcept {
  plan_ = plan;
  active_ = plan.status == PlanStatus::kSuccess && plan.waypoint_count > 0 && plan.waypoint_count <= kMaxWaypoints;
  if (!active_) plan_.waypoint_count = 0;
  elapsed_ = 0;
  segment_ = 0;
}

JointArray PathFollower::tick() noexcept {
  if (!active_) return position();
  ++elapsed_;
  const JointArray q = position();
  active_ = segment_ + 1 < plan_.waypoint_count;
  return q;
}

JointArray PathFollower::position() noexcept {
  return pathJoints(plan_, seconds(), &segment_);
}

JointArray pathJoints(const PlanResult& plan, double seconds, std::uint32_t* segment) noexcept {
  while (*segment + 1 < plan.waypoint_count && seconds >= plan.arrival[*segment + 1])
    ++*segment;
  if (*segment + 1 >= plan.waypoint_count) return plan.waypoints[*segment];
  const JointArray& from = plan.waypoints[*segment];
  const JointArray& to = plan.waypoints[*segment + 1];
  const double departure = plan.arrival[*segment];
  // Positive: every segment that is over was left, and the first one cannot be over before it began.
  const double duration = plan.arrival[*segment + 1] - departure;
  const double blend = duration > 0.0 ? quinticBlend((seconds - departure) / duration) : 0.0;
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = from[j] + blend * (to[j] - from[j]);
  return q;
}

}  // namespace raven2_trainer::control
