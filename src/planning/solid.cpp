#include "planning/solid.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::planning {
namespace {

/** Edges nearer to parallel than this (sine squared) span no separating axis that the faces do not. */
constexpr double kParallel = 1e-10;

Solid makeBox(const Pose& X_WS, const Vector3& half) {
  Solid solid;
  solid.round = false;
  solid.X_WS = X_WS;
  solid.half = half;
  int longest = 0;
  half.maxCoeff(&longest);
  Vector3 along = Vector3::Zero(), across = half;
  along(longest) = half(longest);
  across(longest) = 0.0;
  solid.axis = {X_WS * Vector3(-along), X_WS * along};
  solid.radius = across.norm();
  return solid;
}

Solid makeRound(const Pose& X_WS, double radius, double straight) {
  Solid solid;
  const Vector3 half(0.0, 0.0, straight / 2);
  solid.axis = {X_WS * Vector3(-half), X_WS * half};
  solid.radius = radius;
  return solid;
}

double distanceToSegment(const Segment& s, const Vector3& p) noexcept {
  const Vector3 along = s.b - s.a, from = p - s.a;
  const double square = along.squaredNorm();
  const double t = square > 0.0 ? std::clamp(from.dot(along) / square, 0.0, 1.0) : 0.0;
  return (from - t * along).norm();
}

/** The segment p + t d in a box's frame. */
struct Line {
  Vector3 p, d, half;

  double excess(int k, double t) const noexcept {
    const double x = p[k] + t * d[k];
    return x > half[k] ? x - half[k] : std::min(x + half[k], 0.0);
  }
  /** Half the slope of the squared distance: never falls with t. */
  double slope(double t) const noexcept { return d[0] * excess(0, t) + d[1] * excess(1, t) + d[2] * excess(2, t); }
  double distance(double t) const noexcept {
    const double x = excess(0, t), y = excess(1, t), z = excess(2, t);
    return std::sqrt(x * x + y * y + z * z);
  }
};

/** Draws the bracket of the slope's zero together to a piece on which the slope is straight. */
void narrow(const Line& line, double* low, double* high) noexcept {
  for (int k = 0; k < 3; ++k) {
    for (const double face : {-line.half[k], line.half[k]}) {
      const double t = line.d[k] != 0.0 ? (face - line.p[k]) / line.d[k] : 0.0;
      if (!(t > *low && t < *high)) continue;
      (line.slope(t) < 0.0 ? *low : *high) = t;
    }
  }
}

/** Two boxes: centre of the second in the frame of the first, and its axes there. */
struct BoxPair {
  Matrix3 R, absolute;
  Vector3 t;
  const Vector3 &a, &b;

  double faceOfFirst(int i) const noexcept { return std::abs(t[i]) - a[i] - absolute.row(i).dot(b); }
  double faceOfSecond(int j) const noexcept { return std::abs(t.dot(R.col(j))) - b[j] - absolute.col(j).dot(a); }
  double edges(int i, int j) const noexcept {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const double square = R(i1, j) * R(i1, j) + R(i2, j) * R(i2, j);
    if (square < kParallel) return -1.0;
    const double reach =
        a[i1] * absolute(i2, j) + a[i2] * absolute(i1, j) + b[j1] * absolute(i, j2) + b[j2] * absolute(i, j1);
    return (std::abs(t[i2] * R(i1, j) - t[i1] * R(i2, j)) - reach) / std::sqrt(square);
  }
};

double boxSeparation(const Solid& a, const Solid& b) noexcept {
  BoxPair pair{a.X_WS.R.transpose() * b.X_WS.R, {}, a.X_WS.R.transpose() * (b.X_WS.p - a.X_WS.p), a.half, b.half};
  pair.absolute = pair.R.cwiseAbs();
  double widest = -1.0;
  for (int i = 0; i < 3; ++i) {
    widest = std::max({widest, pair.faceOfFirst(i), pair.faceOfSecond(i)});
    for (int j = 0; j < 3; ++j)
      widest = std::max(widest, pair.edges(i, j));
  }
  return widest;
}

}  // namespace

Solid makeSolid(const model::Description& description,
                const model::Link& link,
                const model::CollisionShape& shape,
                const Pose& X_WL,
                double grow) {
  const Pose X_WS = X_WL * shape.X_LS;
  switch (shape.kind) {
    case model::ShapeKind::kBox:
      return makeBox(X_WS, Vector3(shape.size.array() / 2 + grow));
    case model::ShapeKind::kCapsule:
      return makeRound(X_WS, shape.size.x() + grow, shape.size.y());
    case model::ShapeKind::kSphere:
      return makeRound(X_WS, shape.size.x() + grow, 0.0);
    case model::ShapeKind::kMesh:
      break;
  }
  throw ModelException(description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                       ": the planner takes boxes, cylinders and spheres as collision shapes, not meshes");
}

Solid moved(const Solid& solid, const Pose& X) noexcept {
  Solid out = solid;
  out.axis = {X * solid.axis.a, X * solid.axis.b};
  if (!solid.round) out.X_WS = X * solid.X_WS;
  return out;
}

double signedDistance(const Solid& solid, const Vector3& p) noexcept {
  if (solid.round) return distanceToSegment(solid.axis, p) - solid.radius;
  const Vector3 local = solid.X_WS.R.transpose() * (p - solid.X_WS.p);
  const Vector3 out = local.cwiseAbs() - solid.half;
  const double deepest = out.maxCoeff();
  return deepest <= 0.0 ? deepest : out.cwiseMax(0.0).norm();
}

double distanceToBox(const Segment& segment, const Pose& X_WS, const Vector3& half) noexcept {
  const Matrix3 R_SW = X_WS.R.transpose();
  const Line line{R_SW * (segment.a - X_WS.p), R_SW * (segment.b - segment.a), half};
  if (line.slope(0.0) >= 0.0) return line.distance(0.0);
  if (line.slope(1.0) <= 0.0) return line.distance(1.0);
  double low = 0.0, high = 1.0;
  narrow(line, &low, &high);
  const double at_low = line.slope(low), at_high = line.slope(high);
  const double t = at_high > at_low ? low - at_low * (high - low) / (at_high - at_low) : low;
  return line.distance(t);
}

double separation(const Solid& a, const Solid& b) noexcept {
  if (!a.round && !b.round) return boxSeparation(a, b);
  if (a.round && b.round) return std::sqrt(squaredDistance(a.axis, b.axis)) - a.radius - b.radius;
  const Solid &round = a.round ? a : b, &box = a.round ? b : a;
  return distanceToBox(round.axis, box.X_WS, box.half) - round.radius;
}

}  // namespace raven2_trainer::planning
