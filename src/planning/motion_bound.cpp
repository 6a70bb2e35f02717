#include "planning/motion_bound.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::planning {

MotionBound::MotionBound(const ArmChain& chain, int joint, const Solid& shape_J)
    : X_shoulder_elbow_(chain.offset(kElbow)),
      X_elbow_insertion_(chain.offset(kInsertion)),
      joint_(joint),
      innermost_(around(shape_J)) {
  for (int j = joint; j > static_cast<int>(kInsertion); j = ArmChain::parent(j)) {
    constant_[static_cast<std::size_t>(j)] = innermost_.radius;
    innermost_ = turned(chain.offset(j), innermost_);
  }
}

MotionBound::Cylinder MotionBound::around(const Solid& shape_J) {
  Cylinder out{1e9, -1e9, 0.0};
  const auto include = [&out](const Vector3& p, double radius) {
    out.low = std::min(out.low, p.z() - radius);
    out.high = std::max(out.high, p.z() + radius);
    out.radius = std::max(out.radius, std::hypot(p.x(), p.y()) + radius);
  };
  if (shape_J.round) {
    include(shape_J.axis.a, shape_J.radius);
    include(shape_J.axis.b, shape_J.radius);
    return out;
  }
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 sign((corner & 1) * 2 - 1, (corner >> 1 & 1) * 2 - 1, (corner >> 2) * 2 - 1);
    include(shape_J.X_WS * Vector3(sign.cwiseProduct(shape_J.half)), 0.0);
  }
  return out;
}

/** The cylinder that holds `inner`, which turns about the axis of X_PJ, however that one turns about the parent's z. A
 *  point of its end discs is no farther from that axis than from the parent's origin, a point of the axis. */
MotionBound::Cylinder MotionBound::turned(const Pose& X_PJ, const Cylinder& inner) noexcept {
  const Vector3 n = X_PJ.R.col(2);
  const double tilt = std::sqrt(std::max(0.0, 1.0 - n.z() * n.z())) * inner.radius;
  Cylinder out{1e9, -1e9, 0.0};
  for (const double z : {inner.low, inner.high}) {
    const Vector3 c = X_PJ.p + z * n;
    const double across = (c - c.dot(n) * n).norm();
    const double from_origin = std::sqrt(c.squaredNorm() + inner.radius * inner.radius + 2 * inner.radius * across);
    const double from_axis = std::hypot(c.x(), c.y()) + inner.radius;
    out.low = std::min(out.low, c.z() - tilt);
    out.high = std::max(out.high, c.z() + tilt);
    out.radius = std::max(out.radius, std::min(from_origin, from_axis));
  }
  return out;
}

Levers MotionBound::levers(double insertion_a, double insertion_b) const noexcept {
  Levers levers = constant_;
  Cylinder cylinder = innermost_;
  if (joint_ >= static_cast<int>(kInsertion)) {
    levers[kInsertion] = 1.0;
    cylinder.low += std::min(insertion_a, insertion_b);
    cylinder.high += std::max(insertion_a, insertion_b);
    cylinder = turned(X_elbow_insertion_, cylinder);
  }
  if (joint_ >= static_cast<int>(kElbow)) {
    levers[kElbow] = cylinder.radius;
    cylinder = turned(X_shoulder_elbow_, cylinder);
  }
  levers[kShoulder] = cylinder.radius;
  return levers;
}

}  // namespace raven2_trainer::planning
