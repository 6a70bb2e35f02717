#include "raven2_trainer/haptics/force_limiter.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {
namespace {

/** The same direction, at most so long. */
Eigen::Vector3d shortened(const Eigen::Vector3d& v, double length) noexcept {
  const double norm = v.norm();
  if (norm <= length) return v;
  return v * (length / norm);
}

}  // namespace

Eigen::Vector3d ForceLimiter::step(const Eigen::Vector3d& wanted, double seconds) noexcept {
  const bool is_finite = std::isfinite(wanted.norm());
  const Eigen::Vector3d target = is_finite ? shortened(wanted, max_force_) : Eigen::Vector3d::Zero();
  // After a gap the force must not leap: a tick's worth at most. Ticks that follow each other at once get no more.
  const double time = seconds > 0.0 ? std::min(seconds, kTickSeconds) : 0.0;
  const Eigen::Vector3d change = target - force_;
  const double reach = max_slew_ * time;
  // Both ends lie in the ball of max_force, so every point between does.
  force_ = change.norm() <= reach ? target : Eigen::Vector3d(force_ + shortened(change, reach));
  return force_;
}

}  // namespace raven2_trainer::haptics
