#pragma once

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/servo_target.h"

namespace raven2_trainer::control {

constexpr double kPeakRate = 15.0 / 8;  // of the quintic, over its mean
constexpr double kShortestMove = 0.2;   // [s] so that a move of a millimetre stays below 0.15 m/s2; ours

constexpr double kLimitRounding = 1e-9;  // [rad; m] of forward and inverse kinematics, at a joint's limit

inline double turnBetween(const Matrix3& a, const Matrix3& b) noexcept {
  const Quaternion turn(a * b.transpose());
  return 2.0 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
}

inline double distance(const Pose& a, const Pose& b) noexcept {
  return (a.p - b.p).norm();
}

/** The straight line and the shortest turn. @param[in] share [-] 0 `from`, 1 `to`, which is given exactly. */
inline Pose between(const Pose& from, const Pose& to, double share) noexcept {
  if (share >= 1.0) return to;
  const Quaternion turn = Quaternion(from.R).slerp(share, Quaternion(to.R));
  return {turn.normalized().toRotationMatrix(), from.p + share * (to.p - from.p)};
}

inline ServoJoints between(const ServoJoints& from, const ServoJoints& to, double share) noexcept {
  if (share >= 1.0) return to;
  ServoJoints result{};
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    result[j] = from[j] + share * (to[j] - from[j]);
  return result;
}

/** [-] The largest step of a joint in a tick, over what it may be. */
inline double jointStep(const JointArray& from, const JointArray& to, double most_speed, double most_rate) noexcept {
  const ServoJoints a = servoJoints(from), b = servoJoints(to);
  double most = 0.0;
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    most = std::max(most, std::abs(b[j] - a[j]) / (j == kInsertion ? most_speed : most_rate));
  return most / kTickSeconds;
}

}  // namespace raven2_trainer::control
