#include "raven2_trainer/planning/clearance_gauge.h"

#include <gtest/gtest.h>

#include <limits>

#include "planning/arm_clearance.h"
#include "planning/arm_collision.h"
#include "planning_fixtures.h"
#include "shipped_trainer.h"

namespace raven2_trainer::planning {
namespace {

/** Gold arm under the lid behind the left wire: a narrow place. */
constexpr JointArray kInsideTheDome{0.78, 1.62, 0.335, 0.06, -0.015, kPi / 4, kPi / 4};

JointArray somewhere(const ArmGeometry& g, int i, Random* random) {
  return i % 2 == 0 ? test::randomJoints(g, random) : test::randomJointsNear(g, kInsideTheDome, 0.15, random);
}

TEST(ClearanceGauge, IsZeroExactlyWhereFclFindsATouch) {
  const model::RavenModel& raven = test::trainer().raven;
  const ArmGeometry& g = raven.arms.geometry;
  ClearanceGauge gauge(raven, test::trainer().scene);
  SceneObstacles obstacles(test::trainer().scene);
  Random random(11);
  for (const Arm arm : kArms) {
    ArmCollision judge(raven, obstacles, arm, 0.0);
    int touching = 0, differing = 0;
    for (int i = 0; i < 4000; ++i) {
      const JointArray other = i % 3 == 0 ? g.home : test::randomJoints(g, &random);
      const JointArray q = somewhere(g, i, &random);
      judge.placeOther(other);
      const bool touches = judge.touches(q);
      const double distance = gauge.measure(arm, q, other);
      touching += touches ? 1 : 0;
      // FCL's iteration ends within 1e-6 of the exact distance.
      differing += touches ? distance > 2e-6 : distance <= 0.0;
    }
    EXPECT_EQ(differing, 0) << name(arm);
    EXPECT_GT(touching, 400) << name(arm);
    EXPECT_LT(touching, 3600) << name(arm);
  }
}

/** FCL on shapes grown by a length touches exactly where the distance is less than that length. But a box grown by its
 *  faces reaches up to sqrt(3) times as far at its corners, and only one shape of a pair is grown. */
TEST(ClearanceGauge, TellsTheDistanceThatGrownShapesTouchAt) {
  const model::RavenModel& raven = test::trainer().raven;
  const ArmGeometry& g = raven.arms.geometry;
  constexpr double kGrown = 0.004;
  ClearanceGauge gauge(raven, test::trainer().scene);
  SceneObstacles obstacles(test::trainer().scene);
  ArmCollision grown(raven, obstacles, Arm::kGold, kGrown);
  grown.placeOther(g.home);
  Random random(12);
  int near = 0;
  for (int i = 0; i < 4000; ++i) {
    const JointArray q = somewhere(g, i, &random);
    const double distance = gauge.measure(Arm::kGold, q, g.home);
    if (!grown.touches(q)) {
      EXPECT_GT(distance, kGrown - 2e-6);
    } else {
      EXPECT_LT(distance, 1.7321 * kGrown + 2e-6);
    }
    near += distance > 0.0 && distance < 2 * kGrown ? 1 : 0;
  }
  EXPECT_GT(near, 100);
}

TEST(ClearanceGauge, IsNeverLessThanTheBoundOfTheSearch) {
  const model::RavenModel& raven = test::trainer().raven;
  const ArmGeometry& g = raven.arms.geometry;
  ClearanceGauge gauge(raven, test::trainer().scene);
  const DistanceGrid grid(raven, test::trainer().scene);
  ArmClearance bound(raven, grid, Arm::kGreen, 0.0);
  Random random(13);
  for (int i = 0; i < 2000; ++i) {
    const JointArray q = test::randomJoints(g, &random), other = i % 2 == 0 ? g.home : test::randomJoints(g, &random);
    bound.placeOther(other);
    EXPECT_GE(gauge.measure(Arm::kGreen, q, other) + 1e-9, bound.clearance(q, ClearanceGauge::kRange));
  }
}

TEST(ClearanceGauge, OfWhatIsNoPlaceIsNothing) {
  const model::RavenModel& raven = test::trainer().raven;
  ClearanceGauge gauge(raven, test::trainer().scene);
  const JointArray& home = raven.arms.geometry.home;
  ASSERT_GT(gauge.measure(Arm::kGold, home, home), 0.0);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    JointArray q = home;
    q[kElbow] = bad;
    EXPECT_EQ(gauge.measure(Arm::kGold, q, home), 0.0);
    EXPECT_EQ(gauge.measure(Arm::kGold, home, q), 0.0);
  }
}

}  // namespace
}  // namespace raven2_trainer::planning
