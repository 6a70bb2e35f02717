#include "planning/motion_cost.h"

#include <gtest/gtest.h>

#include <vector>

#include "planning_fixtures.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

/** The integral by brute force: central differences of the tip at 4000 instants, trapezoids. Independent of the
 *  Chebyshev machinery under test. */
double bruteForceEffort(const ArmGeometry& geometry, Arm arm, const JointArray& a, const JointArray& b, double T) {
  constexpr int kSteps = 4000;
  const double h = T / kSteps;
  const auto tip = [&](int i) {
    JointArray q{};
    const double s = control::quinticBlend(static_cast<double>(i) / kSteps);
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] = a[j] + s * (b[j] - a[j]);
    return kinematics::forward(geometry, arm, q).p;
  };
  double sum = 0.0;  // the ends are at rest and weigh nothing
  for (int i = 1; i < kSteps; ++i)
    sum += ((tip(i + 1) - 2.0 * tip(i) + tip(i - 1)) / (h * h)).squaredNorm() * h;
  return sum;
}

UnitState randomUnit(Random* random) {
  UnitState unit{};
  for (double& x : unit)
    x = random->uniform(0.0, 1.0);
  return unit;
}

TEST(TipEffort, AgreesWithCentralDifferences) {
  const ArmGeometry geometry = test::geometry();
  const PlannerConfig config = test::plannerConfig();
  const JointSpace space(geometry, 0.5);
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    const Arm arm = kArms[static_cast<std::size_t>(i % 2)];
    const UnitState from = randomUnit(&random);
    // Edges up to 0.85 in the cube, the radius at n = 500: the longest that FMT* tries
    const UnitState far = randomUnit(&random);
    const UnitState to = interpolate(from, far, std::min(1.0, random.uniform(0.02, 0.85) / distance(from, far)));
    const JointArray a = space.toJoints(from), b = space.toJoints(to);
    const double T = edgeDuration(config, a, b);
    const double expected = bruteForceEffort(geometry, arm, a, b, T);
    EXPECT_NEAR(tipEffort(geometry, arm, a, b, T), expected, 0.01 * expected) << "edge " << i;
  }
}

TEST(TipEffort, OfAPureInsertionIsTheClosedForm) {
  // A straight line of length L: integral of (L x 60 s (1-s)(1-2s) / T^2)^2 over T = 120/7 L^2 / T^3
  JointArray a = test::geometry().home, b = a;
  b[kInsertion] += 0.05;
  const double T = 1.7;
  EXPECT_NEAR(tipEffort(test::geometry(), Arm::kGold, a, b, T), 120.0 / 7.0 * 0.05 * 0.05 / (T * T * T), 1e-9);
}

TEST(TipEffort, IsTheSameBothWaysAndZeroOnTheSpot) {
  const JointSpace space(test::geometry(), 0.5);
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const JointArray a = space.toJoints(randomUnit(&random)), b = space.toJoints(randomUnit(&random));
    EXPECT_EQ(tipEffort(test::geometry(), Arm::kGold, a, b, 2.0), tipEffort(test::geometry(), Arm::kGold, b, a, 2.0));
    EXPECT_EQ(tipEffort(test::geometry(), Arm::kGold, a, a, 0.0), 0.0);
  }
}

TEST(EdgeCost, IsLengthPlusEffortWithTheirWeights) {
  PlannerConfig config = test::plannerConfig();
  const ArmGeometry geometry = test::geometry();
  const JointSpace space(geometry, 0.5);
  const UnitState a{0.3, 0.3, 0.3, 0.5, 0.5, 0.5}, b{0.5, 0.4, 0.6, 0.5, 0.7, 0.4};
  const auto cost = [&](double eta_length, double eta_acceleration) {
    config.eta_length = eta_length;
    config.eta_acceleration = eta_acceleration;
    return edgeCost(geometry, config, space, Arm::kGold, a, b);
  };
  EXPECT_DOUBLE_EQ(cost(1.0, 0.0), std::sqrt(0.04 + 0.01 + 0.09 + 0.04 + 0.01));
  EXPECT_GT(cost(0.0, 1.0), 0.0);
  EXPECT_NEAR(cost(0.1, 0.5), 0.1 * cost(1.0, 0.0) + 0.5 * cost(0.0, 1.0), 1e-12);
}

TEST(EdgeCost, TheMidlineMovesNoTip) {
  PlannerConfig config = test::plannerConfig();
  config.eta_length = 0.0;
  const JointSpace space(test::geometry(), 0.5);
  const UnitState a{0.3, 0.3, 0.3, 0.5, 0.5, 0.2}, b{0.3, 0.3, 0.3, 0.5, 0.5, 0.8};
  EXPECT_NEAR(edgeCost(test::geometry(), config, space, Arm::kGold, a, b), 0.0, 1e-12);
}

TEST(JointSpace, GoesThereAndBackAtAFixedOpening) {
  const double opening = 0.6;
  const JointSpace space(test::geometry(), opening);
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    const UnitState unit = randomUnit(&random);
    const JointArray q = space.toJoints(unit);
    EXPECT_NEAR(kinematics::jawOpening(q), opening, 1e-12);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_GE(q[j], test::geometry().q_min[j] - 1e-12);
      EXPECT_LE(q[j], test::geometry().q_max[j] + 1e-12);
    }
    const UnitState back = space.toUnit(q);
    for (std::size_t k = 0; k < kPlanDimension; ++k)
      EXPECT_NEAR(back[k], unit[k], 1e-12);
  }
}

TEST(JointSpace, KnowsWhatIsOutside) {
  const JointSpace space(test::geometry(), 0.6);
  EXPECT_TRUE(space.contains({0, 1, 0.5, 0.5, 0.5, 0.5}, 0.0));
  EXPECT_FALSE(space.contains({-0.01, 1, 0.5, 0.5, 0.5, 0.5}, 0.0));
  EXPECT_TRUE(space.contains({-0.01, 1, 0.5, 0.5, 0.5, 0.5}, 0.02));
  EXPECT_FALSE(space.contains({std::nan(""), 1, 0.5, 0.5, 0.5, 0.5}, 0.02));
  // Jaws opened by more than both can go leave the mid-line no room.
  EXPECT_FALSE(JointSpace(test::geometry(), 4.0).contains({0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, 0.0));
}

}  // namespace
}  // namespace raven2_trainer::planning
