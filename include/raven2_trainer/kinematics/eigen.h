#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "raven2_trainer/core/types.h"

// Eigen views of the plain arrays of core. Real-time safe: fixed sizes, no allocation.

namespace raven2_trainer {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

inline Vector3 toEigen(const Vec3& v) noexcept {
  return {v[0], v[1], v[2]};
}

inline Vec3 toArray(const Vector3& v) noexcept {
  return {v.x(), v.y(), v.z()};
}

inline Quaternion toEigen(const Quat& q) noexcept {
  return {q[3], q[0], q[1], q[2]};
}

inline Quat toArray(const Quaternion& q) noexcept {
  return {q.x(), q.y(), q.z(), q.w()};
}

/** Position and orientation of one frame in another, for maths. */
struct Pose {
  Matrix3 R{Matrix3::Identity()};
  Vector3 p{Vector3::Zero()};

  Pose operator*(const Pose& other) const noexcept { return {R * other.R, R * other.p + p}; }
  Vector3 operator*(const Vector3& point) const noexcept { return R * point + p; }
  Pose inverse() const noexcept { return {R.transpose(), -(R.transpose() * p)}; }
};

inline Pose toEigen(const RigidPose& pose) noexcept {
  return {toEigen(pose.q).toRotationMatrix(), toEigen(pose.p)};
}

inline RigidPose toArray(const Pose& pose) noexcept {
  return {toArray(pose.p), toArray(Quaternion(pose.R))};
}

}  // namespace raven2_trainer
