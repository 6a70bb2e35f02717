#include "planning/arm_chain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planning/judged_pairs.h"
#include "planning/lever_bound.h"
#include "planning/sin_cos.h"
#include "planning_fixtures.h"
#include "shipped_trainer.h"

namespace raven2_trainer::planning {
namespace {

TEST(SinCos, AgreesWithTheCLibrary) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const Pair x{random.uniform(-8, 8), random.uniform(-120, 120)};
    Pair s, c;
    sinCos(x, &s, &c);
    for (int k = 0; k < 2; ++k) {
      ASSERT_NEAR(s[k], std::sin(x[k]), 3e-16) << x[k];
      ASSERT_NEAR(c[k], std::cos(x[k]), 3e-16) << x[k];
    }
  }
}

TEST(SinCos, QuarterTurns) {
  for (int n = -8; n <= 8; ++n) {
    Pair s, c;
    sinCos(Pair{n * kPi / 2, 0.0}, &s, &c);
    EXPECT_NEAR(s[0], std::sin(n * kPi / 2), 1e-16);
    EXPECT_NEAR(c[0], std::cos(n * kPi / 2), 1e-16);
    EXPECT_EQ(s[1], 0.0);
    EXPECT_EQ(c[1], 1.0);
  }
}

struct Robot {
  const model::RavenModel& raven;
  std::vector<double> positions{std::vector<double>(raven.description.links.size())};
  std::vector<Pose> poses{std::vector<Pose>(raven.description.links.size())};

  const Pose& pose(Arm arm, const JointArray& q, int link) {
    PerArm<JointArray> both{raven.arms.geometry.home, raven.arms.geometry.home};
    at(both, arm) = q;
    raven.linkPosesInWorld(both, &positions, &poses);
    return poses[static_cast<std::size_t>(link)];
  }
};

ArmChain::Frames framesAt(const ArmChain& chain, const JointArray& q) {
  ArmChain::Frames frames;
  const JointArray u = chain.positions(q);
  chain.placeShaft(u, &frames);
  chain.placeTool(u, &frames);
  return frames;
}

TEST(ArmChain, PutsEveryLinkWhereTheModelPutsIt) {
  const model::RavenModel by_hand = test::raven();
  Random random(2);
  for (const model::RavenModel* raven : {&test::trainer().raven, &by_hand}) {
    Robot robot{*raven};
    for (const Arm arm : kArms) {
      const ArmChain chain(*raven, arm);
      for (int i = 0; i < 200; ++i) {
        const JointArray q = test::randomJoints(raven->arms.geometry, &random);
        const ArmChain::Frames frames = framesAt(chain, q);
        for (const ShapeRef& ref : judgedPairs(*raven, arm, 0.002).own) {
          const ArmChain::Mount mount = chain.mount(ref.link);
          const Pose found = frames[static_cast<std::size_t>(mount.joint)] * mount.X_JL;
          const Pose& expected = robot.pose(arm, q, ref.link);
          ASSERT_LT((found.p - expected.p).norm(), 1e-13);
          ASSERT_LT((found.R - expected.R).norm(), 1e-13);
        }
      }
    }
  }
}

/** A random point of a shape, in the shape's frame. */
Vector3 pointOf(const model::CollisionShape& shape, Random* random) {
  const Vector3 u(random->uniform(-1, 1), random->uniform(-1, 1), random->uniform(-1, 1));
  if (shape.kind == model::ShapeKind::kBox) return u.cwiseProduct(shape.size / 2);
  const Vector3 end(0, 0, u.z() > 0 ? shape.size.y() / 2 : -shape.size.y() / 2);
  return end + shape.size.x() * u.normalized();
}

class LeverBoundTest : public ::testing::TestWithParam<Arm> {};

TEST_P(LeverBoundTest, NoPointMovesFartherThanItSays) {
  const model::RavenModel& raven = test::trainer().raven;
  const ArmChain chain(raven, GetParam());
  Robot robot{raven};
  Random random(3);
  double fullest = 0.0;
  for (const ShapeRef& ref : judgedPairs(raven, GetParam(), 0.0).own) {
    const model::CollisionShape& shape = shapeOf(raven.description, ref);
    const ArmChain::Mount mount = chain.mount(ref.link);
    const LeverBound bound(chain, mount.joint,
                           makeSolid(raven.description, linkOf(raven.description, ref), shape, mount.X_JL, 0.0));
    for (int i = 0; i < 1000; ++i) {
      const JointArray a = test::randomJoints(raven.arms.geometry, &random);
      const JointArray b =
          test::randomJointsNear(raven.arms.geometry, a, random.uniform(0, 1) < 0.5 ? 0.01 : 1.0, &random);
      const Levers levers = bound.levers(chain.positions(a)[kInsertion], chain.positions(b)[kInsertion]);
      double most = 0.0;
      for (std::size_t j = 0; j < kJointCount; ++j)
        most += levers[j] * std::abs(b[j] - a[j]);
      const Vector3 p = shape.X_LS * pointOf(shape, &random);
      const Vector3 before = robot.pose(GetParam(), a, ref.link) * p, after = robot.pose(GetParam(), b, ref.link) * p;
      ASSERT_LE((after - before).norm(), most + 1e-12) << linkOf(raven.description, ref).name;
      fullest = std::max(fullest, (after - before).norm() / most);
    }
  }
  EXPECT_GT(fullest, 0.9);  // some motion almost reaches its bound
}

TEST_P(LeverBoundTest, ALeverIsTheGreatestDistanceFromTheAxis) {
  // GIVEN a ball of 1 mm on the shaft's axis, 0.30 m beyond the remote centre (insertion 0.47 m puts frame 4 on the
  // centre). The axes of shoulder and elbow pass through the centre.
  const model::RavenModel& raven = test::trainer().raven;
  const ArmChain chain(raven, GetParam());
  Solid ball;
  ball.radius = 0.001;
  ball.axis = {Vector3(0, 0, 0.30), Vector3(0, 0, 0.30)};
  JointArray q = raven.arms.geometry.home;
  q[kInsertion] = 0.47;
  const double u = chain.positions(q)[kInsertion];
  const Levers levers = LeverBound(chain, kToolRotation, ball).levers(u, u);
  EXPECT_NEAR(levers[kToolRotation], 0.001, 1e-12);
  EXPECT_DOUBLE_EQ(levers[kInsertion], 1.0);
  EXPECT_NEAR(levers[kElbow], 0.30 * std::sin(52 * kPi / 180), 0.003);  // La23 = 52 degrees between axis 2 and shaft
  EXPECT_NEAR(levers[kShoulder], 0.30, 0.003);  // the ball's distance from the centre, in the worst pose
  for (const Joint after : {kWrist, kGrasp1, kGrasp2})
    EXPECT_EQ(levers[after], 0.0);
}

/** A box or a capsule anywhere about a joint's frame. */
Solid randomSolid(bool is_box, Random* random) {
  const auto x = [random] { return random->uniform(-0.05, 0.05); };
  const auto size = [random] { return random->uniform(0.002, 0.06); };
  const Quaternion turn(random->normal(), random->normal(), random->normal(), random->normal());
  const Pose X{turn.normalized().toRotationMatrix(), {x(), x(), x()}};
  const model::CollisionShape shape =
      is_box ? test::box({size(), size(), size()}, X) : test::capsule(size() / 4, size(), X);
  return makeSolid({}, {}, shape, Pose{}, 0.0);
}

/** The corners of a box, or points on the end balls of a capsule. */
std::vector<Vector3> cornersOf(const Solid& solid) {
  std::vector<Vector3> points;
  for (int i = 0; i < 8; ++i) {
    const Vector3 sign((i & 1) * 2 - 1, (i >> 1 & 1) * 2 - 1, (i >> 2) * 2 - 1);
    const Vector3& end = i < 4 ? solid.axis.a : solid.axis.b;
    points.push_back(solid.round ? Vector3(end + solid.radius * sign.normalized())
                                 : Vector3(solid.X_WS * Vector3(sign.cwiseProduct(solid.half))));
  }
  return points;
}

TEST_P(LeverBoundTest, HoldsForEveryCornerOfAnySolidOnAnyJoint) {
  const model::RavenModel& raven = test::trainer().raven;
  const ArmChain chain(raven, GetParam());
  Random random(4);
  for (int trial = 0; trial < 400; ++trial) {
    const bool is_box = trial % 2 == 0;
    const int joint = trial / 2 % static_cast<int>(kJointCount);
    const Solid solid = randomSolid(is_box, &random);
    const LeverBound bound(chain, joint, solid);
    const std::vector<Vector3> corners = cornersOf(solid);
    // For the joint that carries the solid, the lever is the distance of the farthest point from the axis, z.
    double farthest = 0.0;
    for (const Vector3& p : corners)
      farthest = std::max(farthest, std::hypot(p.x(), p.y()));
    for (int i = 0; i < 40; ++i) {
      const JointArray a = test::randomJoints(raven.arms.geometry, &random);
      const JointArray b = test::randomJointsNear(raven.arms.geometry, a, i % 2 == 0 ? 0.005 : 1.0, &random);
      const Levers levers = bound.levers(chain.positions(a)[kInsertion], chain.positions(b)[kInsertion]);
      if (is_box && joint != static_cast<int>(kInsertion)) {
        ASSERT_NEAR(levers[static_cast<std::size_t>(joint)], farthest, 1e-12) << trial;
      }
      const auto from = framesAt(chain, a), to = framesAt(chain, b);
      for (const Vector3& p : corners) {
        double most = 0.0;
        for (std::size_t j = 0; j < kJointCount; ++j)
          most += levers[j] * std::abs(b[j] - a[j]);
        const auto k = static_cast<std::size_t>(joint);
        ASSERT_LE((to[k] * p - from[k] * p).norm(), most + 1e-12) << trial;
      }
    }
  }
}

TEST_P(LeverBoundTest, HoldsForOneJointThatTurnsAlone) {
  // The bound of a single joint is tight. Test each joint at both ends of the insertion.
  const model::RavenModel& raven = test::trainer().raven;
  const ArmGeometry& g = raven.arms.geometry;
  const ArmChain chain(raven, GetParam());
  Random random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    const int carrier = trial % static_cast<int>(kJointCount);
    const Solid solid = randomSolid(trial % 2 == 0, &random);
    const LeverBound bound(chain, carrier, solid);
    JointArray a = test::randomJoints(g, &random);
    a[kInsertion] = trial % 3 == 0 ? g.q_min[kInsertion] : g.q_max[kInsertion];
    const double u = chain.positions(a)[kInsertion], v = chain.positions(g.home)[kInsertion];
    for (const Levers& levers : {bound.levers(u, u), bound.levers(u, v), bound.levers(v, u)}) {
      for (std::size_t j = 0; j <= static_cast<std::size_t>(carrier); ++j) {
        JointArray b = a;
        b[j] += j == kInsertion ? 0.0 : 1e-4;
        const auto k = static_cast<std::size_t>(carrier);
        for (const Vector3& p : cornersOf(solid)) {
          const double moved = (framesAt(chain, b)[k] * p - framesAt(chain, a)[k] * p).norm();
          ASSERT_LE(moved, levers[j] * 1e-4 + 1e-12) << trial << " joint " << j;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, LeverBoundTest, ::testing::Values(Arm::kGold, Arm::kGreen), [](const auto& instance) {
  return std::string(name(instance.param));
});

}  // namespace
}  // namespace raven2_trainer::planning
