#include "raven2_trainer/kinematics/shortest_turn.h"

#include <cmath>

namespace raven2_trainer::kinematics {

Quaternion shortestTurn(const Vector3& from, const Vector3& to) noexcept {
  const Vector3 a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  Quaternion q;
  if (cosine < -1.0 + 1e-12) {
    q.w() = 0.0;
    q.vec() = a.unitOrthogonal();
  } else {
    const double s = std::sqrt((1.0 + cosine) * 2.0);
    q.vec() = a.cross(b) * (1.0 / s);
    q.w() = s * 0.5;
  }
  return q;
}

}  // namespace raven2_trainer::kinematics
