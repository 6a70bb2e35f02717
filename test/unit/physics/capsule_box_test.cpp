#include "physics/capsule_box.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/shortest_turn.h"
#include "support/effort.h"

namespace raven2_trainer::physics {
namespace {

struct Pair {
  Pose X_WC, X_WB;
  double radius, length;
  Vector3 half;
};

Pose randomPose(Random* random, double spread) {
  const Vector3 axis(random->normal(), random->normal(), random->normal());
  Pose X;
  X.R = Eigen::AngleAxisd(random->uniform(0.0, kPi), axis.normalized()).toRotationMatrix();
  for (int i = 0; i < 3; ++i)
    X.p(i) = random->uniform(-spread, spread);
  return X;
}

/** Distance of the capsule's axis from the box, by searching along it: the distance is convex in the place. */
double axisDistance(const Pair& pair) {
  const auto distance = [&pair](double z) {
    const Vector3 p = pair.X_WB.inverse() * (pair.X_WC * Vector3(0, 0, z));
    return (p.cwiseAbs() - pair.half).cwiseMax(0.0).norm();
  };
  double low = -pair.length / 2, high = pair.length / 2;
  for (int i = 0; i < 200; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (distance(a) > distance(b) ? low : high) = distance(a) > distance(b) ? a : b;
  }
  return distance((low + high) / 2);
}

int overlap(const Pair& pair, OverlapPoints* points, double margin = 0.0) {
  return overlapCapsuleBox(pair.X_WC, pair.radius, pair.length, pair.X_WB, pair.half, margin, points);
}

TEST(CapsuleBox, FindsEveryOverlapAndItsDepthAsASearchAlongTheAxisDoes) {
  Random random(1);
  int touching = 0, axis_inside = 0;
  const auto pairs = static_cast<int>(raven2_trainer::testing::effort(5000, 20000));
  for (int i = 0; i < pairs; ++i) {
    Pair pair{
        randomPose(&random, 1.5), randomPose(&random, 0.5), random.uniform(0.1, 0.5), random.uniform(0.2, 3.0), {}};
    for (int k = 0; k < 3; ++k)
      pair.half(k) = random.uniform(0.05, 1.0);
    const double distance = axisDistance(pair);
    if (std::abs(distance - pair.radius) < 1e-6) continue;
    OverlapPoints points;
    const int count = overlap(pair, &points);
    ASSERT_EQ(count > 0, distance < pair.radius) << i;
    if (count == 0) continue;
    ++touching;
    double deepest = points[0].depth;
    for (int k = 1; k < count; ++k)
      deepest = std::max(deepest, points[static_cast<std::size_t>(k)].depth);
    if (distance > 1e-6) {
      EXPECT_NEAR(deepest, pair.radius - distance, 1e-9) << i;
    } else {
      ++axis_inside;
      EXPECT_GE(deepest, pair.radius - 1e-6) << i;
    }
  }
  EXPECT_GT(4 * touching, pairs);
  EXPECT_GT(20 * axis_inside, pairs);
}

TEST(CapsuleBox, GoingOutAlongTheNormalByTheDepthEndsTheOverlap) {
  Random random(2);
  int checked = 0;
  for (int i = 0; i < 5000; ++i) {
    Pair pair{randomPose(&random, 1.0), randomPose(&random, 0.3), 0.2, 1.0, Vector3(0.5, 0.4, 0.3)};
    OverlapPoints points;
    const int count = overlap(pair, &points);
    if (count == 0) continue;
    const auto is_shallower = [](const OverlapPoint& a, const OverlapPoint& b) { return a.depth < b.depth; };
    const OverlapPoint deepest = *std::max_element(points.begin(), points.begin() + count, is_shallower);
    EXPECT_NEAR(deepest.n_W.norm(), 1.0, 1e-12);
    pair.X_WC.p += deepest.n_W * (deepest.depth + 1e-6);
    EXPECT_EQ(overlap(pair, &points), 0) << i;
    ++checked;
  }
  EXPECT_GT(checked, 1000);
}

/** A bar of 1 mm radius, 4 mm long, whose axis is 0.5 mm below a face and parallel to it. */
TEST(CapsuleBox, AnAxisInTheBoxIsPushedOutOfTheNearestOfTheSixFaces) {
  const Vector3 half(0.010, 0.020, 0.030);
  for (int face = 0; face < 3; ++face) {
    for (const double side : {-1.0, 1.0}) {
      Pair pair{{}, {}, 0.001, 0.004, half};
      const Vector3 normal = side * Vector3::Unit(face);
      pair.X_WC.R = kinematics::shortestTurn(Vector3::UnitZ(), Vector3::Unit((face + 1) % 3)).toRotationMatrix();
      pair.X_WC.p = (half(face) - 0.0005) * normal;
      OverlapPoints points;
      ASSERT_EQ(overlap(pair, &points), 2) << normal.transpose();
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(points[i].depth, 0.0015, 1e-12) << normal.transpose();
        EXPECT_NEAR((points[i].n_W - normal).norm(), 0.0, 1e-12) << normal.transpose();
      }
      EXPECT_NEAR((points[0].p_W - points[1].p_W).norm(), 0.004, 1e-12) << "its two ends";
    }
  }
}

TEST(CapsuleBox, ABarAlongAFaceTouchesAtBothEndsOfTheStretchTheyShare) {
  // GIVEN a bar of 2 mm radius, 20 mm long, lying 0.1 mm deep on a box 4 mm wide, turned a little either way
  for (const double tilt : {0.0, 1e-5, -1e-5}) {
    for (const double side : {-1.0, 1.0}) {
      Pair pair{{}, {}, 0.002, 0.020, Vector3(0.002, 0.010, 0.005)};
      pair.X_WC.R = Eigen::AngleAxisd(kPi / 2 + tilt, Vector3::UnitY()).toRotationMatrix();
      pair.X_WC.p = Vector3(0.0, 0.0, side * (0.005 + 0.0019));
      OverlapPoints points;
      ASSERT_EQ(overlap(pair, &points), 2) << side << " " << tilt;
      EXPECT_NEAR(std::abs(points[0].p_W.x() - points[1].p_W.x()), 0.004, 1e-6);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(points[i].depth, 1e-4, 1e-7);
        EXPECT_NEAR(points[i].n_W.z(), side, 1e-6);
      }
    }
  }
}

TEST(CapsuleBox, TheMarginAddsGapsAndNothingElse) {
  Pair pair{{}, {}, 0.002, 0.020, Vector3(0.002, 0.010, 0.005)};
  pair.X_WC.p = Vector3(0.0, 0.0122, 0.0);  // upright, 0.2 mm from the box
  OverlapPoints points;
  EXPECT_EQ(overlap(pair, &points), 0);
  ASSERT_GE(overlap(pair, &points, 3e-4), 1);
  EXPECT_NEAR(points[0].depth, -2e-4, 1e-12);
}

}  // namespace
}  // namespace raven2_trainer::physics
