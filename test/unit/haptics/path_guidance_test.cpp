#include "raven2_trainer/haptics/path_guidance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/core/types.h"
#include "support/effort.h"
#include "support/sanitizer.h"

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

constexpr GuidanceConfig kConfig{/*enabled=*/true, /*stiffness=*/100.0, /*max_force=*/1.0, /*reach=*/0.02,
                                 /*fade_time=*/0.5};

constexpr double kRounding = 1e-12;  // [N]

GuidePath pathOf(std::initializer_list<Vec3> points) {
  GuidePath path;
  path.plan = 1;
  for (const Vec3& p : points)
    path.points_B[path.count++] = p;
  return path;
}

const GuidePath kStraight = pathOf({{0.0, 0.0, 0.0}, {0.05, 0.0, 0.0}, {0.1, 0.0, 0.0}});

/** A quarter circle of 50 mm about the origin, of 255 chords. */
GuidePath quarterCircle() {
  GuidePath path;
  path.plan = 1;
  path.count = static_cast<std::uint32_t>(kMaxPathPoints);
  for (std::size_t i = 0; i < kMaxPathPoints; ++i) {
    const double angle = 0.5 * kPi * static_cast<double>(i) / static_cast<double>(kMaxPathPoints - 1);
    path.points_B[i] = {0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.0};
  }
  return path;
}

TEST(PathGuidance, IsASpringAcrossThePathAndNothingAlongIt) {
  for (const double along : {0.0, 0.013, 0.05, 0.0731, 0.1}) {
    EXPECT_LT(pathGuidance(kConfig, kStraight, {along, 0.0, 0.0}).norm(), kRounding);
    const Vector3d force = pathGuidance(kConfig, kStraight, {along, 0.003, -0.004});
    EXPECT_NEAR((force - Vector3d(0.0, -0.3, 0.4)).norm(), 0.0, 1e-12) << along;
  }
}

TEST(PathGuidance, PullsToTheNearestPointOfACurve) {
  const GuidePath circle = quarterCircle();
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double angle = random.uniform(0.05, 0.5 * kPi - 0.05), radius = random.uniform(0.042, 0.058);
    const double height = random.uniform(-0.004, 0.004);
    const Vector3d radial(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d force = pathGuidance(kConfig, circle, radius * radial + Vector3d(0.0, 0.0, height));
    // of the true circle; its chords sag by R (1 - cos(0.5 pi / 510)) = 0.24 um
    const Vector3d expected = 100.0 * ((0.05 - radius) * radial - Vector3d(0.0, 0.0, height));
    ASSERT_NEAR((force - expected).norm(), 0.0, 100.0 * 0.25e-6 + 100.0 * 0.01 * 0.0031) << angle << " " << radius;
    ASSERT_LT(std::abs(force.dot(Vector3d(-radial.y(), radial.x(), 0.0))), 100.0 * 0.01 * 0.0031);
  }
}

TEST(PathGuidance, PastAnEndPullsToThatEnd) {
  EXPECT_NEAR((pathGuidance(kConfig, kStraight, {-0.004, 0.0, 0.0}) - Vector3d(0.4, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((pathGuidance(kConfig, kStraight, {0.103, 0.004, 0.0}) - Vector3d(-0.3, -0.4, 0.0)).norm(), 0.0, 1e-12);
}

TEST(PathGuidance, LetsGoFarPastAnEndToo) {
  // 24 mm past the end and 18 mm to the side: 30 mm from the path, halfway between reach and twice the reach
  EXPECT_NEAR((pathGuidance(kConfig, kStraight, {0.124, 0.018, 0.0}) - Vector3d(-0.4, -0.3, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(pathGuidance(kConfig, kStraight, {0.141, 0.004, 0.0}), Vector3d::Zero());
}

/** [J] of the force on the straight line from a to b, per metre of the tip: Simpson's rule. */
double workBetween(const GuidePath& path, const Vector3d& a, const Vector3d& b, int steps) {
  double work = 0.0;
  for (int i = 0; i < steps; ++i) {
    const Vector3d from = a + (b - a) * (static_cast<double>(i) / steps);
    const Vector3d to = a + (b - a) * (static_cast<double>(i + 1) / steps);
    const Vector3d mean = (pathGuidance(kConfig, path, from) + 4.0 * pathGuidance(kConfig, path, 0.5 * (from + to)) +
                           pathGuidance(kConfig, path, to)) /
                          6.0;
    work += mean.dot(to - from);
  }
  return work;
}

double workAround(const GuidePath& path, const std::vector<Vector3d>& corners, int steps = 2000) {
  double work = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    work += workBetween(path, corners[i], corners[(i + 1) % corners.size()], steps);
  return work;
}

/** [J] Independent of the law's direction: the size of the force integrated over the distance. Midpoint rule. */
double potential(double distance) {
  constexpr int kSteps = 4000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double d = distance * (i + 0.5) / kSteps, x = std::clamp((d - 0.02) / 0.02, 0.0, 1.0);
    sum += std::min(100.0 * d, 1.0) * (1.0 - x * x * (3.0 - 2.0 * x));
  }
  return sum * distance / kSteps;
}

constexpr double kQuadrature = 2e-8;  // [J] of some mJ on each side of a loop

TEST(PathGuidance, GivesNothingOnAClosedWayAroundAnEnd) {
  // GIVEN a loop next to the path and back past its end: a force across the path alone would give 0.3 N over some 10 mm
  const std::vector<Vector3d> around{{0.095, 0.003, 0.0}, {0.095, 0.012, 0.0}, {0.12, 0.012, 0.0}, {0.12, 0.003, 0.0}};
  EXPECT_NEAR(workAround(kStraight, around), 0.0, kQuadrature);
  const std::vector<Vector3d> far{{0.09, 0.001, 0.0}, {0.09, 0.035, 0.0}, {0.135, 0.03, 0.0}, {0.135, 0.001, 0.0}};
  EXPECT_NEAR(workAround(kStraight, far), 0.0, kQuadrature) << "through the fading";
}

TEST(PathGuidance, GivesNothingOnAnyClosedWay) {
  // GIVEN polygons anywhere around a straight, a kinked and a curved path, also at ends, inner corners and the fading
  const GuidePath kinked = pathOf({{0.0, 0.0, 0.0}, {0.05, 0.0, 0.0}, {0.05, 0.03, 0.0}});
  const GuidePath circle = quarterCircle();
  // Where two points of a path are equally near, the direction jumps. On the kinked path: 2 N at most over a step of
  // 12 um, at one place of each side of a polygon. On the curve: 1 N times 6 mrad over 0.1 mm, at some of its 254
  // corners.
  struct Case {
    const GuidePath* path;
    int steps;
    double doubt;  ///< [J]
    std::int64_t runs;
  };
  Random random(3);
  using raven2_trainer::testing::effort;
  using raven2_trainer::testing::kIsSanitized;
  double largest = 0.0;
  for (const Case& c :
       {Case{&kStraight, 2000, 2e-7, effort(5, 10)}, Case{&kinked, 20000, 1e-4, kIsSanitized ? 1 : effort(5, 10)},
        Case{&circle, 2000, 1e-5, kIsSanitized ? 1 : effort(2, 10)}}) {
    for (std::int64_t run = 0; run < c.runs; ++run) {
      std::vector<Vector3d> corners;
      for (int i = 0; i < 5; ++i)
        corners.push_back({random.uniform(-0.05, 0.15), random.uniform(-0.05, 0.08), random.uniform(-0.03, 0.03)});
      EXPECT_NEAR(workAround(*c.path, corners, c.steps), 0.0, c.doubt) << run;
      largest = std::max(largest, std::abs(workBetween(*c.path, corners[0], corners[1], 2000)));
    }
  }
  EXPECT_GT(largest, 0.01) << "there was work to be given back";
}

TEST(PathGuidance, TheWorkIsTheDifferenceOfThePotentials) {
  const Vector3d beside(0.05, 0.033, 0.0), past(0.115, 0.0, 0.008);  // 33 mm and 17 mm from the path
  EXPECT_NEAR(workBetween(kStraight, beside, past, 4000), potential(0.033) - potential(0.017), 1e-7);
  EXPECT_NEAR(workBetween(kStraight, {-0.05, 0.0, 0.0}, {0.0, 0.0, 0.0}, 4000), potential(0.05), 1e-7);
}

TEST(PathGuidance, IsCappedAndLetsGoOfWhoeverGoesElsewhere) {
  EXPECT_NEAR(pathGuidance(kConfig, kStraight, {0.03, 0.0099, 0.0}).norm(), 0.99, 1e-12);
  EXPECT_DOUBLE_EQ(pathGuidance(kConfig, kStraight, {0.03, 0.015, 0.0}).norm(), 1.0);
  EXPECT_DOUBLE_EQ(pathGuidance(kConfig, kStraight, {0.03, 0.02, 0.0}).norm(), 1.0);
  EXPECT_DOUBLE_EQ(pathGuidance(kConfig, kStraight, {0.03, 0.03, 0.0}).norm(), 0.5) << "halfway of the fading";
  EXPECT_EQ(pathGuidance(kConfig, kStraight, {0.03, 0.04, 0.0}), Vector3d::Zero());
  EXPECT_EQ(pathGuidance(kConfig, kStraight, {0.03, 4.0, 0.0}), Vector3d::Zero());
}

TEST(PathGuidance, DoesNotJumpAnywhereNearAKinkedPath) {
  // GIVEN a right-angled path, and pairs of places 10 um apart within 9 mm of it
  const GuidePath kinked = pathOf({{0.0, 0.0, 0.0}, {0.05, 0.0, 0.0}, {0.05, 0.05, 0.0}});
  Random random(2);
  double largest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double along = random.uniform(0.0, 0.1);
    const Vector3d on = along < 0.05 ? Vector3d(along, 0.0, 0.0) : Vector3d(0.05, along - 0.05, 0.0);
    const Vector3d place =
        on + Vector3d(random.uniform(-0.005, 0.005), random.uniform(-0.005, 0.005), random.uniform(-0.005, 0.005));
    Vector3d step(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    step *= 1e-5 / step.norm();
    const Vector3d a = pathGuidance(kConfig, kinked, place), b = pathGuidance(kConfig, kinked, place + step);
    ASSERT_LE(a.norm(), kConfig.max_force);
    // the bisector of the inner side is as far from both lines: the pull changes sides there, not its size
    const bool on_bisector = std::abs((0.05 - place.x()) - place.y()) < 1e-4;
    if (!on_bisector) largest = std::max(largest, (a - b).norm());
  }
  EXPECT_LE(largest, 2.0 * kConfig.stiffness * 1e-5);
}

TEST(PathGuidance, TakesNothingFromPathsOrTipsThatAreNone) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(pathGuidance(kConfig, GuidePath{}, {0.0, 0.001, 0.0}), Vector3d::Zero());
  GuidePath broken = kStraight;
  broken.count = kMaxPathPoints + 1;
  EXPECT_EQ(pathGuidance(kConfig, broken, {0.0, 0.001, 0.0}), Vector3d::Zero());
  for (const double bad : {nan, inf, -inf, 1e200})
    EXPECT_EQ(pathGuidance(kConfig, kStraight, {0.0, bad, 0.0}), Vector3d::Zero());
  const GuidePath point = pathOf({{0.01, 0.0, 0.0}});
  EXPECT_NEAR((pathGuidance(kConfig, point, {0.012, 0.0, 0.0}) - Vector3d(-0.2, 0.0, 0.0)).norm(), 0.0, 1e-12);
  const GuidePath standing = pathOf({{0.01, 0.0, 0.0}, {0.01, 0.0, 0.0}});
  EXPECT_NEAR((pathGuidance(kConfig, standing, {0.012, 0.0, 0.0}) - Vector3d(-0.2, 0.0, 0.0)).norm(), 0.0, 1e-12);
}

TEST(GuidanceFade, RisesWithTimeAndEndsAtOnce) {
  double fade = 0.0;
  for (int k = 1; k <= 500; ++k) {
    fade = nextFade(kConfig, fade, true, 0.001);
    ASSERT_NEAR(fade, k / 500.0, 1e-12);
  }
  EXPECT_EQ(nextFade(kConfig, 1.0, true, 0.001), 1.0);
  EXPECT_EQ(nextFade(kConfig, 0.7, false, 0.001), 0.0);
  EXPECT_EQ(nextFade(kConfig, 0.2, true, -1.0), 0.2);
  EXPECT_EQ(nextFade(kConfig, 0.2, true, std::nan("")), 0.2);
  EXPECT_NEAR(nextFade(kConfig, 0.2, true, 30.0), 0.202, 1e-12) << "a gap counts as a tick";
}

}  // namespace
}  // namespace raven2_trainer::haptics
