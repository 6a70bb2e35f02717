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

double quinticBlendRate(double s) noexcept {
  const double x = std::clamp(s, 0.0, 1.0);
  return 30.0 * x * x * (1.0 - x) * (1.0 - x);
}

JointTarget quinticTarget(const JointArray& from,
                          const JointArray& to,
                          double departure,
                          double arrival,
                          double t) noexcept {
  const double duration = arrival - departure;
  const double s = duration > 0.0 ? (t - departure) / duration : 0.0;
  const double blend = quinticBlend(s), rate = duration > 0.0 ? quinticBlendRate(s) / duration : 0.0;
  JointTarget target;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    target.q[j] = from[j] + blend * (to[j] - from[j]);
    target.dq[j] = rate * (to[j] - from[j]);
  }
  return target;
}

void PathFollower::start(const PlanResult& plan) noexcept {
  plan_ = plan;
  active_ = plan.status == PlanStatus::kSuccess && plan.waypoint_count > 0 && plan.waypoint_count <= kMaxWaypoints;
  if (!active_) plan_.waypoint_count = 0;
  elapsed_ = 0;
  segment_ = 0;
}

JointArray PathFollower::tick() noexcept {
  if (!active_) return target().q;
  ++elapsed_;
  const JointArray q = pathJoints(plan_, seconds(), &segment_);
  active_ = segment_ + 1 < plan_.waypoint_count;
  return q;
}

JointTarget PathFollower::target() const noexcept {
  if (segment_ + 1 >= plan_.waypoint_count) return {plan_.waypoints[segment_], JointArray{}};
  // tick() has left every segment that is over, and the first one cannot be over before it began.
  JointTarget target = quinticTarget(plan_.waypoints[segment_], plan_.waypoints[segment_ + 1], plan_.arrival[segment_],
                                     plan_.arrival[segment_ + 1], seconds());
  if (!active_) target.dq = JointArray{};
  return target;
}

JointArray pathJoints(const PlanResult& plan, double seconds, std::uint32_t* segment) noexcept {
  while (*segment + 1 < plan.waypoint_count && seconds >= plan.arrival[*segment + 1])
    ++*segment;
  if (*segment + 1 >= plan.waypoint_count) return plan.waypoints[*segment];
  const std::uint32_t from = *segment;
  return quinticTarget(plan.waypoints[from], plan.waypoints[from + 1], plan.arrival[from], plan.arrival[from + 1],
                       seconds)
      .q;
}

}  // namespace raven2_trainer::control
