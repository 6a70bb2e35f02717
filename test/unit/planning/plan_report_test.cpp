#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "planning/roll_out.h"
#include "raven2_trainer/config/load_problem.h"
#include "raven2_trainer/planning/path_planner.h"
#include "shipped_trainer.h"

// Tests that a plan's report of its path equals the report of following the path again, with the other arm in place.

namespace raven2_trainer::planning {
namespace {

using test::trainer;

const std::atomic<bool> kGoOn{false};

/** The shipped problem in which the arms work close together. */
PlanRequest twoArms() {
  return config::findProblem(RAVEN2_TRAINER_SOURCE_DIR "/config/problems", "two_arms", trainer().raven.arms.geometry)
      .request;
}

RollOutReport followAgain(const PlanRequest& request, const PlanResult& plan) {
  const SceneObstacles obstacles(trainer().scene);
  RollOut roll_out(trainer().raven, obstacles, trainer().config.model, plan.arm);
  const auto count = static_cast<std::ptrdiff_t>(plan.waypoint_count);
  return roll_out.follow({plan.waypoints.begin(), plan.waypoints.begin() + count},
                         {plan.arrival.begin(), plan.arrival.begin() + count}, request.other);
}

TEST(PlanReport, IsThatOfThePathFollowedBesideTheOtherArm) {
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner, trainer().config.model);
  const PlanRequest request = twoArms();
  ASSERT_NE(request.other, trainer().raven.arms.geometry.home);
  PlanStatistics statistics;
  const PlanResult plan =
      planner.plan(request, 1, true, kGoOn, defaultOptions(trainer().config.planner), &statistics);
  ASSERT_EQ(plan.status, PlanStatus::kSuccess);
  const RollOutReport again = followAgain(request, plan);
  EXPECT_TRUE(again.free);
  EXPECT_EQ(plan.tracking_error, again.tracking_error);
  // Both are lower bounds of one distance: one within 0.5 mm or a quarter of it, the other by ArmClearance.
  EXPECT_NEAR(plan.clearance, again.clearance, 0.001 + 0.5 * again.clearance);
  EXPECT_GT(plan.clearance, 0.0);
  // AND the next plan counts its roll-outs from zero
  EXPECT_EQ(planner.progress().rollouts.load(), statistics.rollouts);
  ASSERT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kSuccess);
  EXPECT_EQ(planner.progress().rollouts.load(), statistics.rollouts);
}

}  // namespace
}  // namespace raven2_trainer::planning
