#include "raven2_trainer/haptics/spring_damper.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::haptics {

using Eigen::Vector3d;

Vector3d springDamper(const HapticGains& gains,
                      const Vector3d& p_model,
                      const Vector3d& p_robot,
                      const Vector3d& v_model,
                      const Vector3d& v_robot) noexcept {
  const Vector3d e = p_model - p_robot;
  const double distance = e.norm();
  const double speed = (v_model - v_robot).norm();
  if (!std::isfinite(distance) || !std::isfinite(speed)) return Vector3d::Zero();
  if (distance <= gains.tolerance) return Vector3d::Zero();

  // eq. (5): magnitude from both norms
  const double force = std::clamp(gains.kp * distance + gains.kd * speed, gains.min_force, gains.max_force);

  // eq. (6): direction from the position error alone
  return force * e / distance;
}

}  // namespace raven2_trainer::haptics
