#include "raven2_trainer/control/tip_path.h"

#include <gtest/gtest.h>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::control {
namespace {

ArmGeometry geometry() {
  ArmGeometry g;
  g.d4 = -0.47;
  g.lw = 0.013;
  return g;
}

PlanResult planOf(std::uint32_t waypoints) {
  PlanResult plan;
  plan.id = 7;
  plan.status = PlanStatus::kSuccess;
  plan.arm = Arm::kGreen;
  plan.waypoint_count = waypoints;
  for (std::uint32_t i = 0; i < waypoints && i < kMaxWaypoints; ++i)
    plan.waypoints[i] = {0.3 + 0.01 * i, 1.4 - 0.02 * i, 0.40 + 0.0005 * i, 0.0, 0.1, 0.2, 0.2};
  return plan;
}

double distance(const Vec3& a, const Vec3& b) {
  return (toEigen(a) - toEigen(b)).norm();
}

class TipPath : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(TipPath, RunsThroughEveryWaypointAndInStraightLinesOfJointsBetween) {
  const PlanResult plan = planOf(GetParam());
  const GuidePath path = tipPath(geometry(), plan);
  EXPECT_EQ(path.plan, 7U);
  EXPECT_EQ(path.arm, Arm::kGreen);
  ASSERT_GE(path.count, plan.waypoint_count);
  ASSERT_LE(path.count, kMaxPathPoints);
  const std::uint32_t edges = plan.waypoint_count - 1;
  if (edges == 0) {
    EXPECT_EQ(path.count, 1U);
    return;
  }
  ASSERT_EQ((path.count - 1) % edges, 0U);
  const std::uint32_t pieces = (path.count - 1) / edges;
  for (std::uint32_t i = 0; i < path.count; ++i) {
    const std::uint32_t edge = std::min(i / pieces, edges - 1);
    const double share = static_cast<double>(i - edge * pieces) / pieces;
    JointArray q{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] = (1.0 - share) * plan.waypoints[edge][j] + share * plan.waypoints[edge + 1][j];
    const Vec3 tip = toArray(kinematics::forward(geometry(), Arm::kGreen, q).p);
    ASSERT_LT(distance(path.points_B[i], tip), 1e-12) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Waypoints, TipPath, ::testing::Values(1, 2, 3, 10, 64));

TEST(TipPathOf, APlanThatFailedOrCannotBeIsEmpty) {
  PlanResult failed = planOf(3);
  failed.status = PlanStatus::kNoPath;
  EXPECT_EQ(tipPath(geometry(), failed).count, 0U);
  EXPECT_EQ(tipPath(geometry(), failed).plan, 0U);
  EXPECT_EQ(tipPath(geometry(), planOf(0)).count, 0U);
  EXPECT_EQ(tipPath(geometry(), planOf(65)).count, 0U);
}

}  // namespace
}  // namespace raven2_trainer::control
