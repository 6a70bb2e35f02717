#include "render/planned_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "plan_fixture.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

const ArmGeometry& geometry() {
  static const TrainerConfig kConfig = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  return kConfig.arms.geometry;
}

Pose somewhere() {
  return {Eigen::AngleAxisd(0.7, Vector3(1.0, 2.0, 3.0).normalized()).toRotationMatrix(), {0.1, -0.2, 0.3}};
}

/** Joints at a share of the edge from one waypoint to the next. */
JointArray jointsAt(const PlanResult& plan, std::size_t edge, double share) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = (1.0 - share) * plan.waypoints[edge][j] + share * plan.waypoints[edge + 1][j];
  return q;
}

/** [m] in W, the tip at a share of an edge. */
Vector3 tipAt(const PlanResult& plan, std::size_t edge, double share) {
  return somewhere() * kinematics::forward(geometry(), plan.arm, jointsAt(plan, edge, share)).p;
}

double distanceToPath(const PlanResult& plan, const Vector3& p_W) {
  double least = 1e9;
  for (std::size_t edge = 0; edge + 1 < plan.waypoint_count; ++edge) {
    for (int i = 0; i <= 2000; ++i)
      least = std::min(least, (tipAt(plan, edge, i / 2000.0) - p_W).norm());
  }
  return least;
}

TEST(PlannedPath, TheTubeRunsAlongTheTipsPathFromEndToEnd) {
  for (const Arm arm : kArms) {
    const PlanResult plan = makePlan(geometry(), arm);
    const model::Mesh tube = PlannedPath(geometry(), somewhere(), plan).tube();
    ASSERT_GT(tube.vertices.size(), 60U);
    for (std::size_t i = 0; i < tube.vertices.size(); i += 7) {
      const auto& v = tube.vertices[i];
      EXPECT_NEAR(distanceToPath(plan, {v[0], v[1], v[2]}), 0.0013, 1e-4) << i;
    }
    const auto &first = tube.vertices.front(), &last = tube.vertices.back();
    EXPECT_NEAR((Vector3(first[0], first[1], first[2]) - tipAt(plan, 0, 0.0)).norm(), 0.0013, 1e-6);
    EXPECT_NEAR((Vector3(last[0], last[1], last[2]) - tipAt(plan, 1, 1.0)).norm(), 0.0013, 1e-6);
  }
}

TEST(PlannedPath, TheStopsAreTheWaypoints) {
  const PlanResult plan = makePlan(geometry(), Arm::kGreen);
  const PlannedPath path(geometry(), somewhere(), plan);
  ASSERT_EQ(path.stops().size(), 3U);
  EXPECT_LT((path.stops()[0] - tipAt(plan, 0, 0.0)).norm(), 1e-12);
  EXPECT_LT((path.stops()[1] - tipAt(plan, 1, 0.0)).norm(), 1e-12);
  EXPECT_LT((path.stops()[2] - tipAt(plan, 1, 1.0)).norm(), 1e-12);
}

/** The place on the path where the travelled triangles end. */
Vector3 endOfTravelled(const model::Mesh& tube, std::uint32_t triangles) {
  const std::size_t circle = triangles / 12;  // 2 x 6 sides a piece
  Vector3 sum(0.0, 0.0, 0.0);
  for (std::size_t i = 6 * circle; i < 6 * (circle + 1); ++i)
    sum += Vector3(tube.vertices[i][0], tube.vertices[i][1], tube.vertices[i][2]);
  return sum / 6.0;
}

TEST(PlannedPath, JointsOnThePathAreWhereTheyAreOnIt) {
  const PlanResult plan = makePlan(geometry(), Arm::kGold);
  const PlannedPath path(geometry(), somewhere(), plan);
  for (std::size_t edge = 0; edge < 2; ++edge) {
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
      const double place = static_cast<double>(edge) + share;
      EXPECT_NEAR(path.placeOf(jointsAt(plan, edge, share)), place, 1e-9);
      JointArray beside = jointsAt(plan, edge, share);
      beside[kToolRotation] += 0.05;
      EXPECT_NEAR(path.placeOf(beside), place, 1e-9) << "moved at a right angle to the path";
    }
  }
  JointArray before = plan.waypoints[0];
  before[kShoulder] -= 0.1;
  EXPECT_EQ(path.placeOf(before), 0.0);
}

/** 20 mm of insertion count as 0.2 rad. So half of the shoulder's 0.1 rad is a tenth of the edge. */
TEST(PlannedPath, TenCentimetresOfInsertionAreAsFarAsARadian) {
  PlanResult plan = makePlan(geometry(), Arm::kGreen);
  plan.waypoint_count = 2;
  plan.waypoints[1] = plan.waypoints[0];
  plan.waypoints[1][kShoulder] += 0.1;
  plan.waypoints[1][kInsertion] += 0.02;
  const PlannedPath path(geometry(), somewhere(), plan);
  JointArray q = plan.waypoints[0];
  q[kShoulder] += 0.05;
  EXPECT_NEAR(path.placeOf(q), 0.05 * 0.1 / (0.1 * 0.1 + 0.2 * 0.2), 1e-9);
}

TEST(PlannedPath, WhatIsBehindEndsWhereTheArmIs) {
  const PlanResult plan = makePlan(geometry(), Arm::kGold);
  const PlannedPath path(geometry(), somewhere(), plan);
  const model::Mesh tube = path.tube();
  EXPECT_EQ(path.trianglesBefore(0.0), 0U);
  EXPECT_EQ(path.trianglesBefore(path.placeOf(plan.waypoints[2])), tube.triangles.size());
  for (std::size_t edge = 0; edge < 2; ++edge) {
    for (const double share : {0.2, 0.5, 0.8}) {
      const std::uint32_t triangles = path.trianglesBefore(static_cast<double>(edge) + share);
      EXPECT_LT((endOfTravelled(tube, triangles) - tipAt(plan, edge, share)).norm(), 0.0055) << edge << " " << share;
    }
  }
  const std::uint32_t first_edge = path.trianglesBefore(1.0);
  EXPECT_LT((endOfTravelled(tube, first_edge) - tipAt(plan, 0, 1.0)).norm(), 1e-6) << "a piece ends at a stop";
}

TEST(PlannedPath, AStopIsBehindOnceTheArmWasThere) {
  const PlannedPath path(geometry(), somewhere(), makePlan(geometry(), Arm::kGold));
  EXPECT_EQ(path.stopsBefore(0.0), 0U);
  EXPECT_EQ(path.stopsBefore(0.2), 1U);
  EXPECT_EQ(path.stopsBefore(0.99), 1U);
  EXPECT_EQ(path.stopsBefore(1.0), 2U);
  EXPECT_EQ(path.stopsBefore(1.9), 2U);
  EXPECT_EQ(path.stopsBefore(2.0), 3U);
}

TEST(PlannedPath, PlansThatNoLogShouldHoldDoNoHarm) {
  PlanResult plan = makePlan(geometry(), Arm::kGold);
  plan.waypoints[1].fill(kNan);
  const PlannedPath damaged(geometry(), somewhere(), plan);
  for (const auto& vertex : damaged.tube().vertices)
    EXPECT_TRUE(std::isfinite(vertex[0] + vertex[1] + vertex[2]));
  EXPECT_EQ(damaged.placeOf(plan.waypoints[0]), 0.0);
  for (const double place : {-1e300, 0.5, 1e300, kNan}) {
    EXPECT_LE(damaged.trianglesBefore(place), damaged.tube().triangles.size());
    EXPECT_LE(damaged.stopsBefore(place), damaged.stops().size());
  }
  plan.waypoint_count = 4'000'000'000U;
  EXPECT_TRUE(PlannedPath(geometry(), somewhere(), plan).tube().triangles.empty());
  EXPECT_EQ(PlannedPath(geometry(), somewhere(), plan).stopsBefore(0.5), 0U);
}

TEST(PlannedPath, AnArmThatStaysWhereItIsHasStopsAndNoTube) {
  PlanResult plan = makePlan(geometry(), Arm::kGold);
  plan.waypoints[1] = plan.waypoints[2] = plan.waypoints[0];
  const PlannedPath path(geometry(), somewhere(), plan);
  EXPECT_EQ(path.stops().size(), 3U);
  EXPECT_TRUE(path.tube().triangles.empty());
  EXPECT_EQ(path.trianglesBefore(2.0), 0U);
}

TEST(PlanAtHand, IsTheOneThatThePlanningStateNamesOrThatGuidesTheHand) {
  Snapshot snapshot;
  for (std::size_t status = 0; status < kPlanningStatusCount; ++status) {
    setPlan(makePlan(geometry(), Arm::kGold), static_cast<PlanningStatus>(status), &snapshot);
    const bool is_kept = status >= static_cast<std::size_t>(PlanningStatus::kReady);
    EXPECT_EQ(planAtHand(snapshot) != nullptr, is_kept) << kPlanningStatusNames[status];
  }
  snapshot.model.planning.plan = kPlan + 1;
  EXPECT_EQ(planAtHand(snapshot), nullptr) << "the snapshot holds another plan";
  snapshot.model.planning.status = PlanningStatus::kIdle;
  snapshot.model.guide_plan = kPlan;
  ASSERT_NE(planAtHand(snapshot), nullptr);
  EXPECT_EQ(planAtHand(snapshot)->id, kPlan);
}

TEST(PlanAtHand, OutlivesTheRefusalOfALaterRequest) {
  Snapshot snapshot;
  setPlan(makePlan(geometry(), Arm::kGold), PlanningStatus::kReady, &snapshot);
  PlanResult refusal;
  refusal.id = kPlan + 1;
  refusal.status = PlanStatus::kCancelled;
  snapshot.plans.add(std::make_shared<const PlanResult>(refusal));
  ASSERT_NE(planAtHand(snapshot), nullptr);
  EXPECT_EQ(planAtHand(snapshot)->id, kPlan);
}

TEST(PlanAtHand, IsNoneForAnArmOrWaypointsThatThereAreNot) {
  Snapshot snapshot;
  PlanResult plan = makePlan(geometry(), Arm::kGold);
  plan.arm = static_cast<Arm>(7);
  setPlan(plan, PlanningStatus::kReady, &snapshot);
  EXPECT_EQ(planAtHand(snapshot), nullptr);
  for (const std::uint32_t count : {0U, static_cast<std::uint32_t>(kMaxWaypoints) + 1}) {
    plan = makePlan(geometry(), Arm::kGold);
    plan.waypoint_count = count;
    setPlan(plan, PlanningStatus::kReady, &snapshot);
    EXPECT_EQ(planAtHand(snapshot), nullptr) << count;
  }
}

}  // namespace
}  // namespace raven2_trainer::render
