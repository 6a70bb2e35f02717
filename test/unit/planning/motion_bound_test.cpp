#include "planning/motion_bound.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planning/arm_collision.h"
#include "planning_fixtures.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

JointArray randomJoints(const ArmGeometry& g, Random* random) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = random->uniform(g.q_min[j], g.q_max[j]);
  return q;
}

JointArray nearTo(JointArray q, double reach, Random* random) {
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] += random->uniform(-reach, reach) * (j == kInsertion ? 0.1 : 1.0);
  return q;
}

/** Points all over the shapes of an arm, in W. */
std::vector<Vector3> pointsOfArm(const model::RavenModel& raven, Arm arm, const JointArray& q) {
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(raven.description.links.size());
  raven.linkPosesInWorld({q, q}, &positions, &poses);
  std::vector<Vector3> points;
  for (const int link : at(raven.links, arm)) {
    const auto i = static_cast<std::size_t>(link);
    for (const model::CollisionShape& shape : raven.description.links[i].collisions) {
      const double radius = shape.size.x();  // capsules all
      for (const double end : {-0.5, 0.5}) {
        for (const Vector3& n : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0), Vector3(0, -1, 0),
                                 Vector3(0, 0, 2 * end), Vector3(0.6, 0.8, 0.0)})
          points.push_back(poses[i] * (shape.X_LS * Vector3(radius * n + Vector3(0, 0, end * shape.size.y()))));
      }
    }
  }
  return points;
}

TEST(MotionBound, NoPointMovesFarther) {
  const model::RavenModel raven = test::raven();
  Random random(11);
  double tightest = 0.0;
  for (const Arm arm : kArms) {
    MotionBound bound(raven, arm);
    for (int trial = 0; trial < 2000; ++trial) {
      const JointArray a = randomJoints(raven.arms.geometry, &random);
      const JointArray b = nearTo(a, trial % 2 == 0 ? 0.002 : 0.15, &random);
      bound.startFrom(a);
      const double limit = bound(b);
      const std::vector<Vector3> before = pointsOfArm(raven, arm, a), after = pointsOfArm(raven, arm, b);
      for (std::size_t i = 0; i < before.size(); ++i) {
        const double moved = (after[i] - before[i]).norm();
        ASSERT_LE(moved, limit) << name(arm) << " " << trial;
        tightest = std::max(tightest, moved / limit);
      }
    }
  }
  EXPECT_GT(tightest, 0.8) << "a bound of twice that would be of no use";
}

TEST(MotionBound, NothingComesNearerByMore) {
  // GIVEN a ball in reach and the other arm near: distances among parts of the arm count as well
  const model::RavenModel raven = test::raven();
  const SceneObstacles scene(test::scene({test::sphere(0.02, {Matrix3::Identity(), {0.03, 0.02, 0.03}})}));
  Random random(12);
  for (const Arm arm : kArms) {
    MotionBound bound(raven, arm);
    ArmCollision collision(raven, scene, arm, 0.0);
    collision.placeOther(raven.arms.geometry.home);
    for (int trial = 0; trial < 500; ++trial) {
      const JointArray a = randomJoints(raven.arms.geometry, &random), b = nearTo(a, 0.05, &random);
      bound.startFrom(a);
      EXPECT_GE(collision.distance(b, 1.0), collision.distance(a, 1.0) - bound(b) - 1e-6) << trial;
    }
  }
}

TEST(MotionBound, OneJointMovesItsFarthestPointByTheBound) {
  // A slider moves all points by what it slides; a hinge the farthest by its chord, nearly.
  const model::RavenModel raven = test::raven();
  MotionBound bound(raven, Arm::kGold);
  const JointArray home = raven.arms.geometry.home;
  bound.startFrom(home);
  JointArray q = home;
  q[kInsertion] += 0.01;
  EXPECT_NEAR(bound(q), 0.01, 1e-12);
  q = home;
  q[kShoulder] += 1e-3;
  double farthest = 0.0;
  const std::vector<Vector3> before = pointsOfArm(raven, Arm::kGold, home), after = pointsOfArm(raven, Arm::kGold, q);
  for (std::size_t i = 0; i < before.size(); ++i)
    farthest = std::max(farthest, (after[i] - before[i]).norm());
  EXPECT_NEAR(bound(q), farthest, 0.05 * farthest);
}

TEST(MotionBound, SaysNothingOfLargeTurns) {
  const model::RavenModel raven = test::raven();
  MotionBound bound(raven, Arm::kGold);
  JointArray q = raven.arms.geometry.home;
  bound.startFrom(q);
  q[kToolRotation] += 0.6;
  EXPECT_TRUE(std::isinf(bound(q)));
}

}  // namespace
}  // namespace raven2_trainer::planning
