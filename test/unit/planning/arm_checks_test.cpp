#include "planning/arm_checks.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "planning_fixtures.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "shipped_trainer.h"

// Tests the checks of one plan against the arm's surroundings, and that a plan leaves nothing behind for the next one.

namespace raven2_trainer::planning {
namespace {

constexpr double kClearance = 0.002, kEdgeStep = 0.01;
constexpr double kBetween = 0.002 / 8.0;  // [m] half a step of an edge at a tight end moves no point of a tool by more
constexpr double kEndReach = 0.03;  // [-] in the cube: arm_checks.h, "near that end"

/** Small balls all over the place where the tools work. */
model::SceneModel strewnBalls() {
  Random random(31);
  std::vector<model::CollisionShape> shapes;
  for (int i = 0; i < 60; ++i) {
    // one a line: compilers differ in the order in which they evaluate arguments
    const double z = random.uniform(0.0, 0.10);
    const double y = random.uniform(-0.08, 0.08);
    const double x = random.uniform(-0.08, 0.08);
    shapes.push_back(test::sphere(random.uniform(0.001, 0.004), {Matrix3::Identity(), Vector3(x, y, z)}));
  }
  return test::scene(shapes);
}

class ArmChecksOf : public ::testing::TestWithParam<Arm> {
 protected:
  ArmChecks make() const {
    return ArmChecks(raven_, obstacles_, grid_, GetParam(), kClearance, kEdgeStep);
  }

  UnitState randomUnit() {
    UnitState unit{};
    for (double& x : unit)
      x = random_.uniform(0.0, 1.0);
    return unit;
  }

  JointArray randomOther() { return test::randomJoints(raven_.arms.geometry, &random_); }

  /** A state that touches nothing, but is nearer than the clearance. */
  UnitState randomTight(ArmChecks* checks) {
    for (;;) {
      const UnitState unit = randomUnit();
      if (!checks->isFree(unit) && checks->allowEnd(unit)) return unit;
    }
  }

  const model::RavenModel raven_ = test::raven();
  const JointArray home_ = raven_.arms.geometry.home;
  const model::SceneModel scene_ = strewnBalls();
  const SceneObstacles obstacles_{scene_};
  const DistanceGrid grid_{raven_, scene_};
  Random random_{32};
};

INSTANTIATE_TEST_SUITE_P(Both, ArmChecksOf, ::testing::ValuesIn(kArms), [](const auto& instance) {
  return std::string(name(instance.param));
});

TEST_P(ArmChecksOf, NothingOfOnePlanIsLeftInTheNext) {
  // GIVEN a series of plans, each with another pose of the other arm and another opening of the jaws
  ArmChecks used = make(), fresh = make();
  int differing = 0, allowed = 0, edges = 0, free_edges = 0;
  for (int plan = 0; plan < 20; ++plan) {
    const JointSpace space(raven_.arms.geometry, random_.uniform(0.0, 2.0));
    const JointArray other = randomOther(), elsewhere = randomOther();
    // WHEN the used checks have answered before for another pose, opening and end
    const JointSpace another(raven_.arms.geometry, 0.5);
    used.begin(another, elsewhere);
    const UnitState tight = randomTight(&used);
    fresh.begin(another, home_);  // allows no end
    used.begin(space, other);
    fresh.begin(space, other);
    // THEN they answer like new checks
    EXPECT_FALSE(used.isAllowedEnd(tight));
    const UnitState beside = interpolate(tight, randomUnit(), 0.1);
    EXPECT_EQ(used.isEdgeFree(tight, beside), fresh.isEdgeFree(tight, beside)) << plan;
    for (int i = 0; i < 40; ++i) {
      const UnitState a = randomUnit(), b = interpolate(a, randomUnit(), 0.2);
      const JointArray q = space.toJoints(a);
      EXPECT_EQ(used.isFree(a), fresh.isFree(a));
      EXPECT_EQ(used.isEdgeFree(a, b), fresh.isEdgeFree(a, b));
      EXPECT_EQ(used.clearance(q, 0.05), fresh.clearance(q, 0.05));
      const bool may_end = fresh.allowEnd(a);
      EXPECT_EQ(used.allowEnd(a), may_end);
      EXPECT_EQ(used.isAllowedEnd(a), may_end && !fresh.isFree(a));
      allowed += may_end ? 1 : 0;
      ++edges;
      free_edges += fresh.isEdgeFree(a, b) ? 1 : 0;
    }
    fresh.begin(space, elsewhere);
    for (int i = 0; i < 100; ++i) {
      const UnitState a = randomUnit();
      differing += used.isFree(a) != fresh.isFree(a) ? 1 : 0;
    }
  }
  EXPECT_GT(differing, 0) << "the other arm must be an obstacle somewhere";
  EXPECT_GT(allowed, 100);
  EXPECT_GT(free_edges, 50);
  EXPECT_LT(free_edges, edges);
}

TEST_P(ArmChecksOf, AnswersForTheOpeningOfItsPlan) {
  ArmChecks checks = make();
  ArmCollision judge(raven_, obstacles_, GetParam(), kClearance);
  judge.placeOther(home_);
  int differing = 0;
  for (const double opening : {0.1, 2.0, 0.1}) {
    const JointSpace space(raven_.arms.geometry, opening), another(raven_.arms.geometry, 1.0);
    checks.begin(space, home_);
    for (int i = 0; i < 300; ++i) {
      const UnitState unit = randomUnit();
      const bool touches = judge.touches(space.toJoints(unit));
      EXPECT_FALSE(checks.isFree(unit) && touches);
      differing += touches != judge.touches(another.toJoints(unit)) ? 1 : 0;
    }
  }
  EXPECT_GT(differing, 0) << "the jaws must touch something somewhere";
}

/** Whether an edge touches nothing in 100 places, and keeps the clearance except near its tight end. */
bool keepsTheContract(ArmCollision* bare,
                      ArmCollision* kept,
                      const JointSpace& space,
                      const UnitState& tight,
                      const UnitState& to) {
  for (int i = 0; i <= 100; ++i) {
    const UnitState unit = interpolate(tight, to, i / 100.0);
    const JointArray q = space.toJoints(unit);
    if (bare->touches(q)) return false;
    if (distance(tight, unit) > kEndReach && kept->touches(q)) return false;
  }
  return true;
}

TEST_P(ArmChecksOf, EdgesAtATightEndAreLetOffTheClearanceNearItAndTheTouchNowhere) {
  ArmChecks checks = make();
  ArmCollision bare(raven_, obstacles_, GetParam(), 0.0);
  ArmCollision kept(raven_, obstacles_, GetParam(), kClearance - kBetween);
  const JointSpace space(raven_.arms.geometry, kinematics::jawOpening(home_));
  for (ArmCollision* judge : {&bare, &kept})
    judge->placeOther(home_);
  int called_free = 0, within = 0, kept_all = 0;
  for (int i = 0; i < 250; ++i) {
    checks.begin(space, home_);
    const UnitState tight = randomTight(&checks);
    const UnitState to = interpolate(tight, randomUnit(), i % 2 == 0 ? 0.15 : 0.05);
    const bool free = checks.isEdgeFree(tight, to), keeps = keepsTheContract(&bare, &kept, space, tight, to);
    EXPECT_EQ(checks.isEdgeFree(to, tight), free) << i;
    EXPECT_FALSE(free && !keeps) << i;
    called_free += free ? 1 : 0;
    within += keeps ? 1 : 0;
    kept_all += !keeps ? 1 : 0;
  }
  EXPECT_GT(called_free, 0.8 * within) << "the tight end is let off; else no plan could leave such a place";
  EXPECT_GT(called_free, 20);
  EXPECT_GT(kept_all, 20);
}

TEST_P(ArmChecksOf, AnEdgeBetweenTwoTightEndsIsLetOffTheClearanceNearBoth) {
  ArmChecks checks = make();
  ArmCollision bare(raven_, obstacles_, GetParam(), 0.0);
  bare.placeOther(home_);
  const JointSpace space(raven_.arms.geometry, kinematics::jawOpening(home_));
  const auto touches = [&](const UnitState& a, const UnitState& b) {
    for (int i = 0; i <= 100; ++i) {
      if (bare.touches(space.toJoints(interpolate(a, b, i / 100.0)))) return true;
    }
    return false;
  };
  int edges = 0, called_free = 0;
  for (int i = 0; i < 1000; ++i) {
    checks.begin(space, home_);
    const UnitState start = randomTight(&checks), to = randomUnit();
    const UnitState goal = interpolate(start, to, 1.8 * kEndReach / distance(start, to));  // all of it is near an end
    if (checks.isFree(goal) || !checks.allowEnd(goal) || touches(start, goal)) continue;
    ++edges;
    called_free += checks.isEdgeFree(start, goal) ? 1 : 0;
  }
  EXPECT_GT(edges, 10);
  EXPECT_GT(called_free, 0.9 * edges);
}

}  // namespace
}  // namespace raven2_trainer::planning
