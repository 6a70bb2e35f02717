#include "physics/capsule_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raven2_trainer::physics {
namespace {

// Below this the capsule's axis itself is taken to be inside the box, and the direction out is no longer the one to
// the axis' nearest point. [m]
constexpr double kInside = 1e-9;
// Sine of the angle from which on a direction counts as askew to a face's normal.
constexpr double kAskew = 0.05;
// Points nearer than this part of the radius are one.
constexpr double kSameShare = 1e-3;

/** The capsule's axis from a to b, and the box's half edges; all in the box's frame. */
struct Scene {
  Vector3 a, d;  // a + t d, t in [0, 1]
  Vector3 half;
  double radius, margin;

  Vector3 at(double t) const noexcept { return a + t * d; }
};

struct Range {
  double low{0.0}, high{1.0};
};

struct LocalPoint {
  Vector3 axis;    // on the capsule's axis
  Vector3 normal;  // out of the box
  double depth;
};

Vector3 excess(const Vector3& p, const Vector3& half) noexcept {
  return p - p.cwiseMax(-half).cwiseMin(half);
}

/** Half the derivative of the squared distance to the box along the axis: piecewise linear, never falling. */
double slope(const Scene& s, double t) noexcept {
  return s.d.dot(excess(s.at(t), s.half));
}

/** Where the axis crosses the planes of the faces, in order, between 0 and 1. */
struct Crossings {
  std::array<double, 8> t{};
  std::size_t count{0};

  explicit Crossings(const Scene& s) noexcept {
    t[count++] = 0.0;
    for (int i = 0; i < 3; ++i) {
      if (s.d(i) == 0.0) continue;
      for (const double face : {-s.half(i), s.half(i)}) {
        const double at = (face - s.a(i)) / s.d(i);
        if (at > 0.0 && at < 1.0) t[count++] = at;
      }
    }
    t[count++] = 1.0;
    std::sort(t.begin(), t.begin() + count);
  }
};

/** Nearest point of the axis to the box; the distance is convex along the axis. */
double nearest(const Scene& s) noexcept {
  if (slope(s, 0.0) >= 0.0) return 0.0;
  if (slope(s, 1.0) <= 0.0) return 1.0;
  const Crossings crossings(s);
  for (std::size_t i = 1; i < crossings.count; ++i) {
    const double t0 = crossings.t[i - 1], t1 = crossings.t[i];
    const double low = slope(s, t0), high = slope(s, t1);
    if (high < 0.0) continue;
    return high > low ? t0 + (t1 - t0) * -low / (high - low) : t0;
  }
  return 1.0;
}

/** The stretch of the axis that lies over the feature (face, edge or corner) whose normal is along `n`. A bar that is
 *  nearly parallel to a face has its nearest point a hair beyond the face's edge: it still lies on the face. */
Range stretchOver(const Scene& s, const Vector3& n) noexcept {
  Range range;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(n(i)) > kAskew * n.norm() || s.d(i) == 0.0) continue;
    const double t0 = (-s.half(i) - s.a(i)) / s.d(i), t1 = (s.half(i) - s.a(i)) / s.d(i);
    range.low = std::max(range.low, std::min(t0, t1));
    range.high = std::min(range.high, std::max(t0, t1));
  }
  return range;
}

LocalPoint outside(const Scene& s, double t) noexcept {
  const Vector3 p = s.at(t), e = excess(p, s.half);
  const double distance = e.norm();
  return {p, distance > 0.0 ? Vector3(e / distance) : Vector3(Vector3::Zero()), s.radius - distance};
}

int add(const LocalPoint& point, const Scene& s, int count, std::array<LocalPoint, 3>* points) noexcept {
  if (point.depth <= -s.margin || point.normal.isZero()) return count;
  for (int i = 0; i < count; ++i) {
    if (((*points)[static_cast<std::size_t>(i)].axis - point.axis).norm() < kSameShare * s.radius) return count;
  }
  (*points)[static_cast<std::size_t>(count)] = point;
  return count + 1;
}

/** The nearest point, and the ends of the shared stretch as far as they overlap. */
int pointsOutside(const Scene& s, double t, std::array<LocalPoint, 3>* points) noexcept {
  const LocalPoint closest = outside(s, t);
  if (closest.depth <= -s.margin) return 0;
  const Range range = stretchOver(s, excess(closest.axis, s.half));
  int count = add(closest, s, 0, points);
  if (range.low > range.high) return count;
  count = add(outside(s, range.low), s, count, points);
  return add(outside(s, range.high), s, count, points);
}

struct WayOut {
  Vector3 normal{0, 0, 1};
  double depth{};
  bool is_face{};
};

/** Shortest way out of the box for an axis that is in it: over a face, or across an edge (separating axes). */
WayOut shortestWayOut(const Scene& s) noexcept {
  WayOut best;
  best.depth = std::numeric_limits<double>::infinity();
  const Vector3 b = s.at(1.0);
  for (int i = 0; i < 3; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const double depth = s.half(i) - std::min(side * s.a(i), side * b(i));
      if (depth < best.depth) best = {side * Vector3::Unit(i), depth, true};
    }
  }
  // Of an axis parallel to a face an edge's normal may be the face's: the face comes first, it has both ends.
  for (int i = 0; i < 3; ++i) {
    const Vector3 across = s.d.cross(Vector3::Unit(i));
    const double norm = across.norm();
    if (norm < 1e-9 * s.d.norm()) continue;
    const Vector3 n = across / norm * (across.dot(s.a) < 0.0 ? -1.0 : 1.0);
    const double depth = s.half.dot(n.cwiseAbs()) - n.dot(s.a);
    if (depth < best.depth - kInside) best = {n, depth, false};
  }
  return best;
}

int pointsInside(const Scene& s, std::array<LocalPoint, 3>* points) noexcept {
  const WayOut out = shortestWayOut(s);
  if (!out.is_face) {
    const Crossings crossings(s);  // the middle of the part that is inside
    double low = 1.0, high = 0.0;
    for (std::size_t i = 0; i < crossings.count; ++i) {
      if (excess(s.at(crossings.t[i]), s.half).norm() > kInside) continue;
      low = std::min(low, crossings.t[i]);
      high = std::max(high, crossings.t[i]);
    }
    if (low > high) low = high = std::clamp((low + high) / 2, 0.0, 1.0);  // grazed within rounding
    (*points)[0] = {s.at((low + high) / 2), out.normal, out.depth + s.radius};
    return 1;
  }
  const Range range = stretchOver(s, out.normal);
  int count = 0;
  for (const double t : {range.low, range.high}) {
    const Vector3 p = s.at(t);
    count = add({p, out.normal, s.radius + out.normal.cwiseAbs().dot(s.half) - out.normal.dot(p)}, s, count, points);
  }
  return count;
}

}  // namespace

int overlapCapsuleBox(const Pose& X_WC,
                      double radius,
                      double length,
                      const Pose& X_WB,
                      const Vector3& half,
                      double margin,
                      OverlapPoints* points) noexcept {
  const Vector3 centre = X_WB.R.transpose() * (X_WC.p - X_WB.p);
  const Vector3 along = X_WB.R.transpose() * X_WC.R.col(2) * length;
  const Scene scene{centre - along / 2, along, half, radius, margin};
  const double t = nearest(scene);
  const double distance = excess(scene.at(t), half).norm();
  if (distance >= radius + margin) return 0;
  std::array<LocalPoint, 3> local;
  const int count = distance > kInside ? pointsOutside(scene, t, &local) : pointsInside(scene, &local);
  for (int i = 0; i < count; ++i) {
    const LocalPoint& point = local[static_cast<std::size_t>(i)];
    const Vector3 middle = point.axis - point.normal * (radius - point.depth / 2);
    (*points)[static_cast<std::size_t>(i)] = {X_WB.R * middle + X_WB.p, X_WB.R * point.normal, point.depth};
  }
  return count;
}

}  // namespace raven2_trainer::physics
