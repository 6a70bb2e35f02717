#include "raven2_trainer/control/servo_trim.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::control {

void ServoTrim::step(const JointArray& asked, const JointArray& measured, bool rests) noexcept {
  if (time_ <= 0.0) return;
  const double share = kTickSeconds / time_;
  for (std::size_t j = 0; j < kJoints; ++j) {
    double missing = rests ? asked[j] - measured[j] : -joints_[j];
    if (rests && !(std::abs(missing) > kEnough[j])) missing = 0.0;
    const double low = std::clamp(q_min_[j] + kInside - asked[j], -kLimit[j], kInside);
    const double high = std::clamp(q_max_[j] - kInside - asked[j], -kInside, kLimit[j]);
    joints_[j] = std::clamp(joints_[j] + share * missing, low, high);
  }
}

JointArray ServoTrim::with(const JointArray& q) const noexcept {
  JointArray result = q;
  for (std::size_t j = 0; j < kJoints; ++j)
    result[j] += joints_[j];
  return result;
}

JointArray ServoTrim::without(const JointArray& q) const noexcept {
  JointArray result = q;
  for (std::size_t j = 0; j < kJoints; ++j)
    result[j] -= joints_[j];
  return result;
}

Displacement displacement(const ArmGeometry& geometry, Arm arm, const JointArray& from, const JointArray& to) noexcept {
  const Pose before = kinematics::forward(geometry, arm, from);
  const Pose after = kinematics::forward(geometry, arm, to);
  return {after.p - before.p, after.R * before.R.transpose()};
}

}  // namespace raven2_trainer::control
