#pragma once

#include <ode/ode.h>

#include "raven2_trainer/kinematics/eigen.h"

// Between Eigen and ODE, whose rotations are row-major 3 x 4 and whose quaternions are w, x, y, z. Real-time safe.

namespace raven2_trainer::physics {

inline Vector3 vectorFromOde(const dReal* v) noexcept {
  return {v[0], v[1], v[2]};
}

inline Matrix3 rotationFromOde(const dReal* R) noexcept {
  Matrix3 result;
  result << R[0], R[1], R[2], R[4], R[5], R[6], R[8], R[9], R[10];
  return result;
}

inline void rotationToOde(const Matrix3& R, dMatrix3 result) noexcept {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      result[4 * row + column] = R(row, column);
    result[4 * row + 3] = 0.0;
  }
}

/** Pose of a body: its centre of mass, and the axes of its link. */
inline Pose bodyPose(dBodyID body) noexcept {
  return {rotationFromOde(dBodyGetRotation(body)), vectorFromOde(dBodyGetPosition(body))};
}

inline void setBodyPose(dBodyID body, const Pose& X_WC) noexcept {
  dMatrix3 R;
  rotationToOde(X_WC.R, R);
  dBodySetRotation(body, R);
  dBodySetPosition(body, X_WC.p.x(), X_WC.p.y(), X_WC.p.z());
}

}  // namespace raven2_trainer::physics
