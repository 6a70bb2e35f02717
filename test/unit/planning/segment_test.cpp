#include "planning/segment.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

Vector3 randomPoint(Random* random) {
  return {random->uniform(-1, 1), random->uniform(-1, 1), random->uniform(-1, 1)};
}

double pointToSegment(const Vector3& p, const Segment& s) {
  const Vector3 d = s.b - s.a;
  const double f = d.squaredNorm() > 0 ? std::clamp((p - s.a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
  return (s.a + f * d - p).norm();
}

/** Shortest distance by ternary search along s: the distance to t is convex along it. */
double bySearch(const Segment& s, const Segment& t) {
  double low = 0.0, high = 1.0;
  const auto at = [&](double f) { return pointToSegment(s.a + f * (s.b - s.a), t); };
  for (int i = 0; i < 200; ++i) {
    const double third = (high - low) / 3;
    (at(low + third) < at(high - third) ? high : low) = at(low + third) < at(high - third) ? high - third : low + third;
  }
  return at((low + high) / 2);
}

TEST(SegmentDistance, AgreesWithASearch) {
  Random random(11);
  for (int i = 0; i < 2000; ++i) {
    const Segment s{randomPoint(&random), randomPoint(&random)};
    const Segment t{randomPoint(&random), randomPoint(&random)};
    EXPECT_NEAR(std::sqrt(squaredDistance(s, t)), bySearch(s, t), 1e-7) << i;
    EXPECT_NEAR(squaredDistance(s, t), squaredDistance(t, s), 1e-12);
  }
}

TEST(SegmentDistance, HandlesPointsAndParallels) {
  const Segment x{{0, 0, 0}, {1, 0, 0}};
  EXPECT_DOUBLE_EQ(squaredDistance(x, {{0.5, 2, 0}, {0.5, 2, 0}}), 4.0);  // point to the side
  EXPECT_DOUBLE_EQ(squaredDistance({{3, 0, 0}, {3, 0, 0}}, x), 4.0);      // point beyond the end
  EXPECT_DOUBLE_EQ(squaredDistance({{3, 0, 0}, {3, 0, 0}}, {{0, 4, 0}, {0, 4, 0}}), 25.0);
  EXPECT_DOUBLE_EQ(squaredDistance(x, {{0.2, 0, 3}, {0.7, 0, 3}}), 9.0);   // parallel, side by side
  EXPECT_DOUBLE_EQ(squaredDistance(x, {{3, 0, 0}, {2, 0, 0}}), 1.0);       // on one line
  EXPECT_DOUBLE_EQ(squaredDistance(x, {{0.5, -1, 0}, {0.5, 1, 0}}), 0.0);  // crossing
}

}  // namespace
}  // namespace raven2_trainer::planning
