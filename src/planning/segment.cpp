#include "planning/segment.h"

#include <algorithm>

namespace raven2_trainer::planning {
namespace {

/** Segments nearer to parallel than this (sine squared of their angle) are: any point of one will do then. */
constexpr double kParallelSegments = 1e-12;

/** x / y within [0, 1]; 0 for a segment of no length. */
double fraction(double x, double y) noexcept {
  return y > 0.0 ? std::clamp(x / y, 0.0, 1.0) : 0.0;
}

}  // namespace

double squaredDistance(const Segment& s, const Segment& t) noexcept {
  const Vector3 ds = s.b - s.a, dt = t.b - t.a, r = s.a - t.a;
  const double ss = ds.squaredNorm(), tt = dt.squaredNorm(), st = ds.dot(dt);
  const double sr = ds.dot(r), tr = dt.dot(r);
  const double determinant = ss * tt - st * st;
  double u = determinant > kParallelSegments * ss * tt ? fraction(st * tr - sr * tt, determinant) : 0.0;
  const double v_line = tt > 0.0 ? (st * u + tr) / tt : 0.0;
  const double v = std::clamp(v_line, 0.0, 1.0);
  if (v != v_line || tt == 0.0) u = fraction(st * v - sr, ss);  // beyond t's end: the point of s nearest to that end
  return (r + u * ds - v * dt).squaredNorm();
}

}  // namespace raven2_trainer::planning
