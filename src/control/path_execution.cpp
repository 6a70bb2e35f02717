#include "raven2_trainer/control/path_execution.h"

#include <algorithm>

#include "raven2_trainer/control/path_follower.h"

namespace raven2_trainer::control {

void PathExecution::start(const PlanResult& plan, const JointArray& from) noexcept {
  plan_ = plan;
  plan_.waypoint_count = std::min<std::uint32_t>(plan.waypoint_count, kMaxWaypoints);
  for (std::size_t j = 0; j < kJointCount; ++j)
    offset_[j] = from[j] - plan_.waypoints[0][j];
  target_ = {from, JointArray{}};
  elapsed_ = waiting_ = resting_ = 0;
  rate_ = kFullRate;
  segment_ = 0;
}

const JointTarget& PathExecution::tick(bool may_move) noexcept {
  if (!may_move) {
    ++waiting_;
    rate_ = 0;
    target_.dq = {};
    return target_;
  }
  waiting_ = 0;
  if (isOver()) ++resting_;
  rate_ = std::min(kFullRate, rate_ + 1);
  elapsed_ += rate_;
  const JointArray q = joints();
  for (std::size_t j = 0; j < kJointCount; ++j)
    target_.dq[j] = (q[j] - target_.q[j]) / kTickSeconds;
  target_.q = q;
  return target_;
}

JointArray PathExecution::joints() noexcept {
  JointArray q = pathJoints(plan_, pathTime(), &segment_);
  const double left = 1.0 - quinticBlend(held() / config_.hold_time);
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] += left * offset_[j];
  return q;
}

double PathExecution::duration() const noexcept {
  return plan_.waypoint_count > 0 ? plan_.arrival[plan_.waypoint_count - 1] : 0.0;
}

double PathExecution::progress() const noexcept {
  return isOver() ? 1.0 : std::max(0.0, pathTime() / duration());
}

}  // namespace raven2_trainer::control
