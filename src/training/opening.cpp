#include "training/opening.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::training {
namespace {

constexpr double kUpright = 0.3;  // [-] cosine of the steepest tilt of an object around a peg

/** `p_O` in the object's plane. */
bool isInside(const SceneObject& object, const Vector3& p_O) noexcept {
  const double r = object.inner_radius;
  if (object.square != 0) return std::abs(p_O.x()) < r && std::abs(p_O.y()) < r;
  return p_O.head<2>().squaredNorm() < r * r;
}

}  // namespace

bool isAround(const SceneObject& object, const Pose& X_WO, const ScenePeg& peg) noexcept {
  const Vector3 normal = X_WO.R.col(2), foot = toEigen(peg.base_W);
  if (!(std::abs(normal.z()) >= kUpright)) return false;
  const double above = normal.dot(X_WO.p - foot) / normal.z();  // where the axis meets the object's plane
  if (!(above > 0.0 && above < peg.height)) return false;
  return isInside(object, X_WO.R.transpose() * (foot + above * Vector3::UnitZ() - X_WO.p));
}

double threadedAt(const SceneObject& object, const Pose& X_WO, const SceneWire& wire) noexcept {
  const Vector3 normal = X_WO.R.col(2);
  double along = 0.0, found = -1.0, nearest = 0.0;
  for (std::size_t i = 0; i + 1 < wire.line_W.size(); ++i) {
    const Vector3 a = toEigen(wire.line_W[i]) - X_WO.p, b = toEigen(wire.line_W[i + 1]) - X_WO.p;
    const double height_a = normal.dot(a), height_b = normal.dot(b), length = (b - a).norm();
    const double start = along;
    along += length;
    if ((height_a < 0.0) == (height_b < 0.0)) continue;
    const double share = height_a / (height_a - height_b);
    const Vector3 p_O = X_WO.R.transpose() * (a + share * (b - a));
    if (!isInside(object, p_O) || (found >= 0.0 && p_O.squaredNorm() >= nearest)) continue;
    found = start + share * length;
    nearest = p_O.squaredNorm();
  }
  return found;
}

double lengthOf(const SceneWire& wire) noexcept {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < wire.line_W.size(); ++i)
    length += (toEigen(wire.line_W[i + 1]) - toEigen(wire.line_W[i])).norm();
  return length;
}

Vector3 pointAt(const SceneWire& wire, double along) noexcept {
  for (std::size_t i = 0; i + 1 < wire.line_W.size(); ++i) {
    const Vector3 a = toEigen(wire.line_W[i]), b = toEigen(wire.line_W[i + 1]);
    const double length = (b - a).norm();
    if (along <= length) return length > 0.0 ? Vector3(a + std::max(along / length, 0.0) * (b - a)) : a;
    along -= length;
  }
  return wire.line_W.empty() ? Vector3(Vector3::Zero()) : toEigen(wire.line_W.back());
}

}  // namespace raven2_trainer::training
