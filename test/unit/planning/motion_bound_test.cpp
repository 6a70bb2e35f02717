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

/** Points on all shapes of an arm, in W. */
std::vector<Vector3> pointsOfArm(const model::RavenModel& raven, Arm arm, const JointArray& q) {
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(raven.description.links.size());
  raven.linkPosesInWorld({q, q}, &positions, &poses);
  std::vector<Vector3> points;
  for (const int link : at(raven.links, arm)) {
    const auto i = static_cast<std::size_t>(link);
    for (const model::CollisionShape& shape : raven.description.links[i].collisions) {
      const double radius = shape.size.x();  // all shapes are capsules
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
  EXPECT_GT(tightest, 0.8) << "the bound must be close to the real motion";
}

TEST(MotionBound, NothingComesNearerByMore) {
  // GIVEN a ball in reach and the other arm near. Distances among parts of the arm count as well.
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

/** A shape of any kind, anywhere about the frame of a link. */
model::CollisionShape randomShape(int kind, Random* random) {
  const auto x = [random] { return random->uniform(-0.05, 0.05); };
  const auto size = [random] { return random->uniform(0.002, 0.06); };
  const Quaternion turn(random->normal(), random->normal(), random->normal(), random->normal());
  const Pose X{turn.normalized().toRotationMatrix(), {x(), x(), x()}};
  if (kind == 0) return {model::ShapeKind::kBox, X, {size(), size(), size()}, -1};
  if (kind == 1) return test::capsule(size() / 4, size(), X);
  return test::sphere(size() / 2, X);
}

/** The corners of a box, or surface points of the balls at the ends of a capsule's axis. */
std::vector<Vector3> surfaceOf(const model::CollisionShape& shape) {
  std::vector<Vector3> points;
  for (int i = 0; i < 8; ++i) {
    const Vector3 sign((i & 1) * 2 - 1, (i >> 1 & 1) * 2 - 1, (i >> 2) * 2 - 1);
    const double half = shape.kind == model::ShapeKind::kCapsule ? shape.size.y() / 2 : 0.0;
    points.push_back(shape.X_LS * (shape.kind == model::ShapeKind::kBox
                                       ? Vector3(shape.size.cwiseProduct(sign) / 2)
                                       : Vector3(Vector3(0, 0, half * sign.z()) + shape.size.x() * sign.normalized())));
  }
  return points;
}

/** [m] Largest motion of these points of a link. */
double farthestMotion(const model::RavenModel& raven,
                      int link,
                      const std::vector<Vector3>& points,
                      const JointArray& a,
                      const JointArray& b) {
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> before(positions.size()), after(positions.size());
  raven.linkPosesInWorld({a, a}, &positions, &before);
  raven.linkPosesInWorld({b, b}, &positions, &after);
  double farthest = 0.0;
  for (const Vector3& p : points) {
    const auto i = static_cast<std::size_t>(link);
    farthest = std::max(farthest, (after[i] * p - before[i] * p).norm());
  }
  return farthest;
}

TEST(MotionBound, NoCornerOfAnyShapeMovesFartherAndTheFarthestByNearlyTheBound) {
  // GIVEN one shape alone on a link, and one joint that moves a little: the farthest corner moves by its chord
  Random random(14);
  for (const Arm arm : kArms) {
    for (int trial = 0; trial < 600; ++trial) {
      model::RavenModel raven = test::raven();
      for (model::Link& link : raven.description.links)
        link.collisions.clear();
      const int link = at(raven.links, arm)[static_cast<std::size_t>(3 + trial % 4)];
      auto& shapes = raven.description.links[static_cast<std::size_t>(link)].collisions;
      shapes.push_back(randomShape(trial % 3, &random));
      MotionBound bound(raven, arm);
      const JointArray a = randomJoints(raven.arms.geometry, &random);
      bound.startFrom(a);
      for (const Joint joint : {kShoulder, kElbow, kInsertion, kToolRotation}) {
        JointArray b = a;
        b[joint] += (trial & 4) != 0 ? 1e-4 : -1e-4;
        const double moved = farthestMotion(raven, link, surfaceOf(shapes[0]), a, b);
        EXPECT_LE(moved, bound(b) + 1e-12) << trial;
        if (trial % 3 == 0) {
          EXPECT_GE(moved, 0.999 * bound(b)) << trial << ": the corners of a box are points, so the bound is tight";
        }
      }
    }
  }
}

TEST(MotionBound, OneJointMovesItsFarthestPointByTheBound) {
  // A slider moves all points by its own motion. A hinge moves the farthest point by nearly its chord.
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
