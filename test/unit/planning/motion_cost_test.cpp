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
  double sum = 0.0;  // the ends are at rest and add nothing
  Vector3 before = tip(0), here = tip(1);
  for (int i = 1; i < kSteps; ++i) {
    const Vector3 next = tip(i + 1);
    sum += ((next - 2.0 * here + before) / (h * h)).squaredNorm() * h;
    before = here;
    here = next;
  }
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
    // Edges up to 0.85 in the cube: the radius at n = 500, and so the longest that FMT* tries.
    const UnitState far = randomUnit(&random);
    const UnitState to = interpolate(from, far, std::min(1.0, random.uniform(0.02, 0.85) / distance(from, far)));
    const JointArray a = space.toJoints(from), b = space.toJoints(to);
    const double T = edgeDuration(config, a, b);
    const double expected = bruteForceEffort(geometry, arm, a, b, T);
    EXPECT_NEAR(tipEffort(geometry, arm, a, b, T), expected, 3e-4 * expected) << "edge " << i;
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

MotionCost makeCost(const CostWeights& weights, ClearanceFunction clearance = {}) {
  const ArmGeometry geometry = test::geometry();
  return MotionCost(geometry, Arm::kGold, JointSpace(geometry, 0.5), test::plannerConfig(), weights,
                    std::move(clearance));
}

TEST(MotionCost, IsLengthPlusEffortWithTheirWeights) {
  const UnitState a{0.3, 0.3, 0.3, 0.5, 0.5, 0.5}, b{0.5, 0.4, 0.6, 0.5, 0.7, 0.4};
  const auto cost = [&](double eta_length, double eta_acceleration) {
    return makeCost({eta_length, eta_acceleration, 0.0, 1.0}).plain(a, b);
  };
  EXPECT_DOUBLE_EQ(cost(1.0, 0.0), std::sqrt(0.04 + 0.01 + 0.09 + 0.04 + 0.01));
  const JointSpace space(test::geometry(), 0.5);
  const JointArray from = space.toJoints(a), to = space.toJoints(b);
  const double T = edgeDuration(test::plannerConfig(), from, to);
  const double effort = bruteForceEffort(test::geometry(), Arm::kGold, from, to, T);
  EXPECT_NEAR(cost(0.0, 1.0), effort, 1e-4 * effort);
  EXPECT_NEAR(cost(0.1, 0.5), 0.1 * cost(1.0, 0.0) + 0.5 * cost(0.0, 1.0), 1e-12);
}

TEST(MotionCost, TheMidlineMovesNoTip) {
  const UnitState a{0.3, 0.3, 0.3, 0.5, 0.5, 0.2}, b{0.3, 0.3, 0.3, 0.5, 0.5, 0.8};
  EXPECT_NEAR(makeCost({0.0, 1.0, 0.0, 1.0}).plain(a, b), 0.0, 1e-12);
}

TEST(MotionCost, ItsBoundIsNeverMoreThanTheCostAndOftenMuchOfIt) {
  // GIVEN the cost computed by brute force, not by the formula under test
  const MotionCost cost = makeCost({0.1, 0.5, 0.0, 1.0});
  const JointSpace space(test::geometry(), 0.5);
  Random random(11);
  double parts = 0.0;
  for (int i = 0; i < 300; ++i) {
    const UnitState a = randomUnit(&random);
    const UnitState b = interpolate(a, randomUnit(&random), random.uniform(0.01, 1.0));
    const JointArray from = space.toJoints(a), to = space.toJoints(b);
    const double effort =
        bruteForceEffort(test::geometry(), Arm::kGold, from, to, edgeDuration(test::plannerConfig(), from, to));
    const double exact = 0.1 * distance(a, b) + 0.5 * effort, bound = cost.lowerBound(cost.end(a), cost.end(b));
    EXPECT_LE(bound, exact * (1 + 1e-6)) << i;
    EXPECT_GE(bound, 0.1 * distance(a, b) * (1 - 1e-6)) << i;
    parts += bound / exact / 300;
  }
  EXPECT_GT(parts, 0.6);
}

TEST(MotionCost, ThePartsOfAPathBoundItFromBelowByLengthAlone) {
  // The search orders by this bound: no detour, however many edges it has, costs less than eta1 x the straight length.
  const MotionCost cost = makeCost({0.1, 0.5, 0.0, 1.0});
  Random random(12);
  for (int i = 0; i < 200; ++i) {
    const UnitState a = randomUnit(&random), b = randomUnit(&random), by = randomUnit(&random);
    EXPECT_GE(cost.plain(a, by) + cost.plain(by, b), cost.lengthWeight() * distance(a, b));
  }
}

TEST(MotionCost, TheClearanceTermIsTheIntegralOverAKnownDistance) {
  // GIVEN a wall at x0 = 0.5. The distance to it is 0.1 m a unit, and counts below 20 mm: from x0 = 0.3 on.
  const ClearanceFunction wall = [](const UnitState& x, double cap) { return std::min(cap, 0.1 * (0.5 - x[0])); };
  const MotionCost cost = makeCost({0.1, 0.5, 2.0, 0.02}, wall);
  const UnitState a{0.1, 0.2, 0.5, 0.5, 0.5, 0.5}, b{0.5, 0.5, 0.5, 0.5, 0.5, 0.5};  // 0.5 long, 0.4 of it along x0
  // THEN eta3 x integral over the last half of ((x0 - 0.3) / 0.2)^2 ds = 2 x 0.25 / 3
  EXPECT_NEAR(cost.clearanceTerm(a, b), 2.0 * 0.25 / 3.0, 0.005 * 2.0 * 0.25 / 3.0);
  EXPECT_NEAR(cost.clearanceTerm(b, a), cost.clearanceTerm(a, b), 1e-12);
  // AND the term is twice the length along the wall in contact, and zero far from the wall
  const UnitState c{0.5, 0.1, 0.5, 0.5, 0.5, 0.5}, far{0.1, 0.9, 0.5, 0.5, 0.5, 0.5};
  EXPECT_NEAR(cost.clearanceTerm(b, c), 2.0 * 0.4, 1e-12);
  EXPECT_EQ(cost.clearanceTerm(a, far), 0.0);
  EXPECT_EQ(makeCost({0.1, 0.5, 0.0, 0.02}, wall).clearanceTerm(a, b), 0.0);
  // AND eq. (1) is the same as without the term
  EXPECT_EQ(cost.plain(a, b), makeCost({0.1, 0.5, 0.0, 1.0}).plain(a, b));
}

TEST(MotionCost, TheClearanceTermAddsUpOverTheParts) {
  const ClearanceFunction wave = [](const UnitState& x, double cap) {
    return std::min(cap, 0.012 + 0.01 * std::sin(9.0 * x[1] + 4.0 * x[3]));
  };
  const MotionCost cost = makeCost({0.0, 0.0, 1.0, 0.02}, wave);
  Random random(13);
  for (int i = 0; i < 50; ++i) {
    const UnitState a = randomUnit(&random), b = randomUnit(&random);
    double fine = 0.0;  // by the midpoint rule at 2000 places
    for (int k = 0; k < 2000; ++k)
      fine += std::pow(std::max(0.0, 1.0 - wave(interpolate(a, b, (k + 0.5) / 2000), 0.02) / 0.02), 2);
    fine *= distance(a, b) / 2000;
    EXPECT_NEAR(cost.clearanceTerm(a, b), fine, 0.01 * fine + 1e-4) << i;
  }
}

TEST(MotionCost, TheClearanceTermIsFollowedAsFarAsItsLimit) {
  int asked = 0;
  const ClearanceFunction wave = [&asked](const UnitState& x, double cap) {
    ++asked;
    return std::min(cap, 0.012 + 0.01 * std::sin(9.0 * x[1] + 4.0 * x[3]));
  };
  const MotionCost cost = makeCost({0.0, 0.0, 1.0, 0.02}, wave);
  Random random(14);
  int all = 0, with_half = 0;
  for (int i = 0; i < 100; ++i) {
    const UnitState a = randomUnit(&random), b = randomUnit(&random);
    asked = 0;
    const double term = cost.clearanceTerm(a, b);
    all += asked;
    // A limit above the term changes no bit. A limit below gives a value between the limit and the term.
    for (const double above : {std::nextafter(term, 1e9), 1.001 * term + 1e-9, 1e9})
      EXPECT_EQ(cost.clearanceTerm(a, b, above), term) << i;
    for (const double part : {-1.0, 0.0, 0.1, 0.9, 1.0}) {
      const double limited = cost.clearanceTerm(a, b, part * term);
      EXPECT_GE(limited, part * term) << i;
      EXPECT_LE(limited, term) << i;
    }
    asked = 0;
    cost.clearanceTerm(a, b, 0.5 * term);
    with_half += asked;
  }
  EXPECT_LT(with_half, 0.75 * all) << "half of the sum is reached about half-way";
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

TEST(JointSpace, KeepsBothJawsWithinTheirOwnLimits) {
  // GIVEN jaws with different limits, which also differ from side to side
  for (const auto& [min1, max1, min2, max2] : {std::array{-1.2, 1.6, -1.6, 1.8}, std::array{-1.8, 1.2, -0.9, 1.5},
                                               std::array{-0.7, 1.8, -1.8, 0.9}, std::array{-0.4, 1.9, -0.5, 1.8}}) {
    ArmGeometry g = test::geometry();
    g.q_min[kGrasp1] = min1;
    g.q_max[kGrasp1] = max1;
    g.q_min[kGrasp2] = min2;
    g.q_max[kGrasp2] = max2;
    const JointSpace space(g, 0.6);
    for (const double end : {0.0, 1.0}) {
      const JointArray q = space.toJoints({0.5, 0.5, 0.5, 0.5, 0.5, end});
      double room = 1.0;  // to the nearest of the four limits; an end of the range is at a limit
      for (const std::size_t j : {kGrasp1, kGrasp2})
        room = std::min({room, q[j] - g.q_min[j], g.q_max[j] - q[j]});
      EXPECT_NEAR(room, 0.0, 1e-12) << end;
    }
  }
}

TEST(JointSpace, KnowsWhatIsOutside) {
  const JointSpace space(test::geometry(), 0.6);
  EXPECT_TRUE(space.contains({0, 1, 0.5, 0.5, 0.5, 0.5}, 0.0));
  EXPECT_FALSE(space.contains({-0.01, 1, 0.5, 0.5, 0.5, 0.5}, 0.0));
  EXPECT_TRUE(space.contains({-0.01, 1, 0.5, 0.5, 0.5, 0.5}, 0.02));
  EXPECT_FALSE(space.contains({std::nan(""), 1, 0.5, 0.5, 0.5, 0.5}, 0.02));
  // Jaws opened by more than both can reach leave no room for the mid-line.
  EXPECT_FALSE(JointSpace(test::geometry(), 4.0).contains({0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, 0.0));
}

}  // namespace
}  // namespace raven2_trainer::planning
