#include "planning/arm_clearance.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "planning/arm_collision.h"
#include "planning_fixtures.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "shipped_trainer.h"

namespace raven2_trainer::planning {
namespace {

constexpr double kClearance = 0.002;

/** Both judges of one arm in one scene. */
struct Judges {
  Judges(const model::RavenModel& raven_model, const model::SceneModel& scene, Arm side)
      : raven(raven_model),
        arm(side),
        obstacles(scene),
        grid(raven, scene),
        exact(raven, obstacles, arm, kClearance),
        fast(raven, grid, arm, kClearance) {
    placeOther(raven.arms.geometry.home);
  }
  void placeOther(const JointArray& q) {
    exact.placeOther(q);
    fast.placeOther(q);
  }

  const model::RavenModel& raven;
  const Arm arm;
  SceneObstacles obstacles;
  DistanceGrid grid;
  ArmCollision exact;
  ArmClearance fast;
};

struct Tally {
  int free{}, touching{}, falsely_free{}, stricter{};

  void add(Judges* judges, const JointArray& q) {
    const bool exactly = !judges->exact.touches(q), fast = judges->fast.isFree(q);
    (exactly ? free : touching)++;
    falsely_free += fast && !exactly ? 1 : 0;
    stricter += exactly && !fast ? 1 : 0;
  }
};

/** Gold arm under the lid behind the left wire: a narrow place. */
constexpr JointArray kInsideTheDome{0.78, 1.62, 0.335, 0.06, -0.015, kPi / 4, kPi / 4};

void expectAgreement(const Tally& tally, double strictness) {
  EXPECT_EQ(tally.falsely_free, 0);
  EXPECT_LE(tally.stricter, strictness * tally.free) << tally.free << " free";
  ::testing::Test::RecordProperty("stricter", tally.stricter);
  ::testing::Test::RecordProperty("free", tally.free);
}

TEST(ArmClearance, IsGivenUpWhereverItsMakingIsToldTo) {
  struct Enough {};
  const test::Trainer& t = test::trainer();
  const DistanceGrid grid(t.raven, t.scene);
  int polls = 0;
  const ArmClearance polled(t.raven, grid, Arm::kGold, kClearance, [&polls] { ++polls; });
  // Nodes: 513 over the shoulder, 129 x 129 over shoulder and elbow, 129 x 65 over elbow and insertion.
  EXPECT_EQ(polls, (513 + 129 * 129 + 129 * 65) / static_cast<int>(EverySoOften::kPieces));
  for (const int last : {1, polls / 2, polls}) {
    int asked = 0;
    const auto enough = [&] {
      if (++asked == last) throw Enough{};
    };
    EXPECT_THROW(ArmClearance(t.raven, grid, Arm::kGold, kClearance, enough), Enough);
    EXPECT_EQ(asked, last);
  }
}

TEST(ArmClearance, AgreesWithTheExactJudgeAllOverTheShippedScene) {
  Random random(1);
  const ArmGeometry& g = test::trainer().raven.arms.geometry;
  for (const Arm arm : kArms) {
    Judges judges(test::trainer().raven, test::trainer().scene, arm);
    Tally tally;
    for (int i = 0; i < 10000; ++i) {
      if (i % 10 == 0) judges.placeOther(i % 20 == 0 ? g.home : test::randomJoints(g, &random));
      tally.add(&judges, test::randomJoints(g, &random));
    }
    expectAgreement(tally, 0.001);
    EXPECT_GT(tally.free, 1000) << name(arm);
    EXPECT_GT(tally.touching, 1000) << name(arm);
  }
}

TEST(ArmClearance, AgreesWithTheExactJudgeInCloseQuarters) {
  Random random(2);
  const ArmGeometry& g = test::trainer().raven.arms.geometry;
  for (const Arm arm : kArms) {
    Judges judges(test::trainer().raven, test::trainer().scene, arm);
    Tally tally;
    for (int i = 0; i < 5000; ++i)
      tally.add(&judges, test::randomJointsNear(g, kInsideTheDome, i % 2 == 0 ? 0.03 : 0.15, &random));
    expectAgreement(tally, 0.005);
    EXPECT_GT(tally.free, 500) << name(arm);
    EXPECT_GT(tally.touching, 500) << name(arm);
  }
}

/** Joints that put an arm's tip at a place in W, oriented as at home; empty if the place is out of reach. */
std::optional<JointArray> jointsAt(const model::RavenModel& raven, Arm arm, const Vector3& tip) {
  const ArmGeometry& g = raven.arms.geometry;
  const Pose X_BT{kinematics::forward(g, arm, g.home).R, at(raven.X_WB, arm).inverse() * tip};
  JointArray near = g.home;
  near[kInsertion] = -g.d4 - X_BT.p.norm();
  const kinematics::IkResult ik = kinematics::inverse(g, arm, X_BT, 0.2, near);
  if (!kinematics::isUsable(ik.status)) return std::nullopt;
  return ik.q;
}

TEST(ArmClearance, AgreesWithTheExactJudgeWithTheArmsAmongEachOther) {
  // GIVEN both tips near one point above the opening of the lid
  Random random(3);
  const model::RavenModel& raven = test::trainer().raven;
  Judges judges(raven, test::trainer().scene, Arm::kGold);
  Tally tally;
  for (int i = 0; i < 200; ++i) {
    const Vector3 meeting(random.uniform(-0.05, 0.0), random.uniform(-0.02, 0.02), random.uniform(0.03, 0.09));
    const auto gold = jointsAt(raven, Arm::kGold, meeting), green = jointsAt(raven, Arm::kGreen, meeting);
    if (!gold || !green) continue;
    judges.placeOther(*green);
    for (int k = 0; k < 10; ++k)
      tally.add(&judges, test::randomJointsNear(raven.arms.geometry, *gold, 0.05, &random));
  }
  expectAgreement(tally, 0.005);
  EXPECT_GT(tally.free, 100);
  EXPECT_GT(tally.touching, 100);
}

/** Balls, capsules and boxes strewn over the place where the tools of test::raven() work. */
model::SceneModel strewnScene(std::uint64_t seed) {
  Random random(seed);
  std::vector<model::CollisionShape> shapes;
  for (int i = 0; i < 25; ++i) {
    const Pose X{
        Quaternion(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix(),
        {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.25)}};
    const auto size = [&] { return random.uniform(0.004, 0.02); };
    if (i % 3 == 0) shapes.push_back(test::sphere(size(), X));
    if (i % 3 == 1) shapes.push_back(test::capsule(size() / 2, size(), X));
    if (i % 3 == 2) shapes.push_back(test::box({size(), size(), size()}, X));
  }
  return test::scene(shapes);
}

/** test::raven() with boxes for jaws, and a box on link 2 that the tool can reach when it is withdrawn. */
model::RavenModel boxyRaven() {
  model::RavenModel raven = test::raven();
  for (const Arm arm : kArms) {
    for (const Joint jaw : {kGrasp1, kGrasp2}) {
      auto& shapes = raven.description.links[static_cast<std::size_t>(at(raven.links, arm)[jaw])].collisions;
      shapes = {test::box({0.012, 0.003, 0.005}, {Matrix3::Identity(), {0.006, 0, 0}})};
    }
    auto& elbow = raven.description.links[static_cast<std::size_t>(at(raven.links, arm)[kElbow])].collisions;
    elbow.push_back(test::box({0.03, 0.02, 0.02}, {Matrix3::Identity(), {0.03, -0.05, -0.05}}));
    elbow.push_back(test::capsule(0.004, 0.03, {Matrix3::Identity(), {-0.03, -0.08, -0.06}}));
  }
  return raven;
}

TEST(ArmClearance, AgreesWithTheExactJudgeInScenesMadeUp) {
  const model::RavenModel capsules = test::raven(), boxes = boxyRaven();
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const model::RavenModel& raven = seed % 2 == 0 ? capsules : boxes;
    const model::SceneModel scene = strewnScene(seed);
    Judges judges(raven, scene, seed < 3 ? Arm::kGold : Arm::kGreen);
    Random random(seed);
    Tally tally;
    for (int i = 0; i < 3000; ++i) {
      if (i % 10 == 0) judges.placeOther(test::randomJoints(raven.arms.geometry, &random));
      tally.add(&judges, test::randomJoints(raven.arms.geometry, &random));
    }
    expectAgreement(tally, 0.005);
    EXPECT_GT(tally.free, 100) << seed;
    EXPECT_GT(tally.touching, 100) << seed;
  }
}

/** Whether 200 states along the edge are free by the exact judge. */
bool isFreeAlong(ArmCollision* exact, const JointArray& a, const JointArray& b) {
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i) {
    JointArray q{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] = a[j] + (b[j] - a[j]) * i / kSteps;
    if (exact->touches(q)) return false;
  }
  return true;
}

TEST(ArmClearance, AnEdgeCalledFreeIsFreeAllAlong) {
  Random random(4);
  const ArmGeometry& g = test::trainer().raven.arms.geometry;
  for (const Arm arm : kArms) {
    Judges judges(test::trainer().raven, test::trainer().scene, arm);
    int called_free = 0, exactly_free = 0, called = 0;
    while (called < 150) {
      const JointArray a =
          called % 2 == 0 ? test::randomJoints(g, &random) : test::randomJointsNear(g, kInsideTheDome, 0.1, &random);
      const JointArray b = test::randomJointsNear(g, a, 0.25, &random);
      if (!judges.fast.isFree(a) || !judges.fast.isFree(b)) continue;
      const bool fast = judges.fast.isEdgeFree(a, b), exactly = isFreeAlong(&judges.exact, a, b);
      EXPECT_FALSE(fast && !exactly) << "edge " << called;
      EXPECT_EQ(fast, judges.fast.isEdgeFree(b, a));
      ++called;
      called_free += fast ? 1 : 0;
      exactly_free += exactly ? 1 : 0;
    }
    EXPECT_GE(called_free, 0.95 * exactly_free) << name(arm);
    EXPECT_GT(called_free, 30) << name(arm);
    EXPECT_LT(exactly_free, 150) << name(arm) << ": some edges must be blocked";
  }
}

TEST(ArmClearance, AnEdgeOfNoLengthIsAState) {
  Judges judges(test::trainer().raven, test::trainer().scene, Arm::kGold);
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const JointArray q = test::randomJoints(judges.raven.arms.geometry, &random);
    EXPECT_EQ(judges.fast.isEdgeFree(q, q), judges.fast.isFree(q));
  }
}

/** Gold shaft of test::raven() at home, in W. */
Pose shaftAtHome(const model::RavenModel& raven) {
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(positions.size());
  raven.linkPosesInWorld({raven.arms.geometry.home, raven.arms.geometry.home}, &positions, &poses);
  return poses[static_cast<std::size_t>(at(raven.links, Arm::kGold)[kToolRotation])];
}

TEST(ArmClearance, MeasuresTheGapToABallBesideTheShaft) {
  const model::RavenModel raven = test::raven();
  const double ball = 0.003, radius = 0.004;
  for (const double gap : {0.0019, 0.0021, 0.003, 0.005, 0.007, 0.009}) {
    const Vector3 centre = shaftAtHome(raven) * Vector3(radius + ball + gap, 0.0, 0.060);
    const model::SceneModel scene = test::scene({test::sphere(ball, {Matrix3::Identity(), centre})});
    Judges judges(raven, scene, Arm::kGold);
    const double found = judges.fast.clearance(raven.arms.geometry.home, 0.02);
    EXPECT_EQ(judges.fast.isFree(raven.arms.geometry.home), gap > kClearance);
    EXPECT_LE(found, gap);
    EXPECT_GE(found, gap > kClearance ? kClearance + 0.6 * (gap - kClearance) : 0.0);
    EXPECT_EQ(found == 0.0, gap < kClearance);
    EXPECT_LE(judges.fast.clearance(raven.arms.geometry.home, 0.001), 0.001);
  }
}

TEST(ArmClearance, FarFromEverythingIsTheCap) {
  const model::RavenModel raven = test::raven();
  const model::SceneModel scene = test::scene({});
  Judges judges(raven, scene, Arm::kGold);
  EXPECT_DOUBLE_EQ(judges.fast.clearance(raven.arms.geometry.home, 0.004), 0.004);
}

TEST(ArmClearance, TheOtherArmMayBeInTheWay) {
  const model::RavenModel raven = test::raven();
  const model::SceneModel scene = test::scene({});
  Judges judges(raven, scene, Arm::kGold);
  const Vector3 meeting(0.02, 0.0, 0.06);
  const auto gold = jointsAt(raven, Arm::kGold, meeting), green = jointsAt(raven, Arm::kGreen, meeting);
  ASSERT_TRUE(gold && green);
  EXPECT_TRUE(judges.fast.isFree(*gold));
  judges.placeOther(*green);
  EXPECT_FALSE(judges.fast.isFree(*gold));
  judges.placeOther(raven.arms.geometry.home);
  EXPECT_TRUE(judges.fast.isFree(*gold));
}

TEST(ArmClearance, NumbersThatAreNoneAreNotFree) {
  const model::RavenModel raven = test::raven();
  const model::SceneModel scene = test::scene({});
  Judges judges(raven, scene, Arm::kGold);
  const JointArray& home = raven.arms.geometry.home;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1e300, 1e9}) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      JointArray q = home;
      q[j] = bad;
      EXPECT_FALSE(judges.fast.isFree(q));
      EXPECT_EQ(judges.fast.clearance(q, 0.01), 0.0);
      EXPECT_FALSE(judges.fast.isEdgeFree(home, q));
      EXPECT_FALSE(judges.fast.isEdgeFree(q, home));
      judges.fast.placeOther(q);
      EXPECT_FALSE(judges.fast.isFree(home));
      judges.fast.placeOther(home);
      EXPECT_TRUE(judges.fast.isFree(home));
    }
  }
}

TEST(ArmClearance, AnswersDoNotDependOnWhatWasAskedBefore) {
  const test::Trainer& t = test::trainer();
  const DistanceGrid grid(t.raven, t.scene), again(t.raven, t.scene);
  ArmClearance forwards(t.raven, grid, Arm::kGreen, kClearance), backwards(t.raven, again, Arm::kGreen, kClearance);
  Random random(6);
  std::vector<JointArray> states;
  for (int i = 0; i < 2000; ++i)
    states.push_back(test::randomJoints(t.raven.arms.geometry, &random));
  std::vector<double> found;
  for (const JointArray& q : states)
    found.push_back(forwards.clearance(q, 0.02));
  for (std::size_t i = states.size(); i-- > 0;)
    ASSERT_EQ(backwards.clearance(states[i], 0.02), found[i]) << i;
}

TEST(ArmClearance, RefusesMoreShapesThanItHasRoomFor) {
  model::RavenModel raven = test::raven();
  auto& shapes = raven.description.links[static_cast<std::size_t>(at(raven.links, Arm::kGold)[kElbow])].collisions;
  shapes.resize(ArmClearance::kMaxShapes, test::sphere(0.001));
  const DistanceGrid grid(raven, test::scene({}));
  EXPECT_THROW(ArmClearance(raven, grid, Arm::kGold, kClearance), ModelException);
}

}  // namespace
}  // namespace raven2_trainer::planning
