#include "planning/solid.h"

#include <gtest/gtest.h>

#include "planning_fixtures.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

Pose randomPose(Random* random, double spread) {
  Quaternion turn(random->normal(), random->normal(), random->normal(), random->normal());
  const auto x = [&] { return random->uniform(-spread, spread); };
  return {turn.normalized().toRotationMatrix(), {x(), x(), x()}};
}

model::CollisionShape randomShape(bool is_box, Random* random) {
  const auto size = [random] { return random->uniform(0.002, 0.05); };
  return is_box ? test::box({size(), size(), size()}) : test::capsule(size() / 2, size(), {});
}

Solid solidOf(const model::CollisionShape& shape, const Pose& X) {
  return makeSolid({}, {}, shape, X, 0.0);
}

/** Nearest point of a shape: of a capsule, the point of its axis, moved to the surface. */
Vector3 project(const model::CollisionShape& shape, const Pose& X, const Vector3& p) {
  const Vector3 local = X.inverse() * p;
  if (shape.kind == model::ShapeKind::kBox)
    return X * Vector3(local.cwiseMax(-shape.size / 2).cwiseMin(shape.size / 2));
  const Vector3 foot(0, 0, std::clamp(local.z(), -shape.size.y() / 2, shape.size.y() / 2));
  const Vector3 out = local - foot;
  return X * Vector3(foot + out * std::min(1.0, shape.size.x() / std::max(out.norm(), 1e-300)));
}

/** Distance by alternating projections (von Neumann), which closes in on it from above; 0 if they overlap. */
double referenceDistance(const model::CollisionShape& a, const Pose& X, const model::CollisionShape& b, const Pose& Y) {
  Vector3 p = X.p, q = Y.p;
  for (int i = 0; i < 3000; ++i) {
    q = project(b, Y, p);
    p = project(a, X, q);
  }
  return (p - q).norm();
}

TEST(Solid, SeparationIsTheDistanceWhereOneIsRound) {
  Random random(1);
  int apart = 0;
  for (int i = 0; i < 600; ++i) {
    const auto a = randomShape(i % 2 == 0, &random), b = randomShape(false, &random);
    const Pose X = randomPose(&random, 0.05), Y = randomPose(&random, 0.05);
    const double expected = referenceDistance(a, X, b, Y), found = separation(solidOf(a, X), solidOf(b, Y));
    EXPECT_NEAR(found, separation(solidOf(b, Y), solidOf(a, X)), 1e-12);
    if (expected < 1e-5) {
      EXPECT_LT(found, 1e-5) << i;
      continue;
    }
    ++apart;
    EXPECT_NEAR(found, expected, 1e-5) << i;
  }
  EXPECT_GT(apart, 200);
  EXPECT_LT(apart, 550);
}

TEST(Solid, SeparationOfBoxesIsPositiveExactlyWhenTheyAreApart) {
  Random random(2);
  int apart = 0;
  for (int i = 0; i < 600; ++i) {
    const auto a = randomShape(true, &random), b = randomShape(true, &random);
    const Pose X = randomPose(&random, 0.03), Y = randomPose(&random, 0.03);
    const double expected = referenceDistance(a, X, b, Y), found = separation(solidOf(a, X), solidOf(b, Y));
    EXPECT_LT(found, expected + 1e-9) << i;
    if (expected > 1e-4) {
      EXPECT_GT(found, 0.0) << i;
    }
    apart += expected > 1e-4 ? 1 : 0;
  }
  EXPECT_GT(apart, 100);
  EXPECT_LT(apart, 550);
}

TEST(Solid, BoxesSideBySideAndCrossedEdgeToEdge) {
  const auto cube = test::box({0.02, 0.02, 0.02});
  EXPECT_NEAR(separation(solidOf(cube, {}), solidOf(cube, {Matrix3::Identity(), {0.025, 0.003, 0}})), 0.005, 1e-15);
  // GIVEN two edges that cross at right angles, along y and z, each on its cube's diagonal. Half a diagonal is
  // 10 sqrt 2 mm.
  const Pose a{Eigen::AngleAxisd(kPi / 4, Vector3::UnitY()).toRotationMatrix(), {0, 0, 0}};
  const Pose b{Eigen::AngleAxisd(kPi / 4, Vector3::UnitZ()).toRotationMatrix(), {0.03, 0, 0}};
  EXPECT_NEAR(separation(solidOf(cube, a), solidOf(cube, b)), 0.03 - 0.02 * std::sqrt(2.0), 1e-12);
}

TEST(Solid, SignedDistanceOfPoints) {
  const Solid box = solidOf(test::box({0.02, 0.04, 0.06}), {});
  EXPECT_DOUBLE_EQ(signedDistance(box, {0.013, 0.024, 0.0}), 0.005);
  EXPECT_DOUBLE_EQ(signedDistance(box, {0.007, 0.0, 0.0}), -0.003);
  const Solid capsule = solidOf(test::capsule(0.003, 0.02, {}), {});
  EXPECT_NEAR(signedDistance(capsule, {0.0, 0.003, 0.014}), 0.002, 1e-15);
  EXPECT_NEAR(signedDistance(capsule, {0.001, 0.0, 0.005}), -0.002, 1e-15);
  const Solid sphere = solidOf(test::sphere(0.005), {});
  EXPECT_NEAR(signedDistance(sphere, {0.0, 0.0, 0.007}), 0.002, 1e-15);
}

TEST(Solid, ABoxLiesInTheCapsuleAroundIt) {
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const model::CollisionShape shape = randomShape(true, &random);
    const double grow = random.uniform(0.0, 0.01);
    const Solid solid = moved(makeSolid({}, {}, shape, randomPose(&random, 0.1), grow), randomPose(&random, 0.1));
    double farthest = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 sign((corner & 1) * 2 - 1, (corner >> 1 & 1) * 2 - 1, (corner >> 2) * 2 - 1);
      const Vector3 p = solid.X_WS * Vector3(solid.half.cwiseProduct(sign));
      farthest = std::max(farthest, std::sqrt(squaredDistance(solid.axis, {p, p})));
    }
    EXPECT_NEAR(farthest, solid.radius, 1e-12) << "a smaller radius would miss shapes; a larger one would waste work";
  }
}

TEST(Solid, GrowsByTheClearanceOnEverySide) {
  const Solid box = makeSolid({}, {}, test::box({0.02, 0.04, 0.06}), {}, 0.002);
  EXPECT_LT((box.half - Vector3(0.012, 0.022, 0.032)).norm(), 1e-15);
  EXPECT_NEAR(makeSolid({}, {}, test::capsule(0.003, 0.02, {}), {}, 0.002).radius, 0.005, 1e-15);
}

}  // namespace
}  // namespace raven2_trainer::planning
