#include "raven2_trainer/control/execution_tally.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raven2_trainer::control {
namespace {

PlanResult plan() {
  PlanResult result;
  result.id = 8;
  result.status = PlanStatus::kSuccess;
  result.arm = Arm::kGreen;
  result.waypoint_count = 3;
  result.arrival[1] = 1.0;
  result.arrival[2] = 2.5;
  result.clearance = 0.004;
  return result;
}

/** Path at x, tips 3-4-5 triangles away; the goal at the origin. */
ExecutionSample sample(double x, double model_off, double robot_off, std::uint32_t contacts = 0) {
  ExecutionSample s;
  s.path_B = {x, 0.0, 0.0};
  s.model_B = {x, 3.0 * model_off, 4.0 * model_off};
  s.robot_B = {x, 0.0, robot_off};
  s.contacts = contacts;
  s.model_clearance = model_off * 10.0;
  s.robot_clearance = robot_off + 0.005;
  return s;
}

TEST(ExecutionTally, GivesMeanLargestAndLastByHand) {
  ExecutionTally tally;
  tally.start(70, plan(), /*on_robot=*/true);
  tally.begin(1000);
  tally.add(sample(0.012, 0.0001, 0.001));      // model 0.5 mm, robot 1 mm off the path
  tally.add(sample(0.006, 0.0004, 0.003, 2));   // 2 mm, 3 mm
  tally.add(sample(0.003, 0.0002, -0.004, 5));  // 1 mm, 4 mm; from the goal sqrt(9 + 1) and 5 mm
  EXPECT_NEAR(tally.deviation(), 0.004, 1e-15);
  EXPECT_NEAR(tally.distanceToGoal(), 0.005, 1e-15);
  const ExecutionReport report = tally.finish(ExecutionEnd::kFinished, 1003, 1.0);
  EXPECT_EQ(report.id, 70U);
  EXPECT_EQ(report.plan, 8U);
  EXPECT_EQ(report.arm, Arm::kGreen);
  EXPECT_EQ(report.on_robot, 1);
  EXPECT_EQ(report.end, ExecutionEnd::kFinished);
  EXPECT_EQ(report.started, 1000);
  EXPECT_EQ(report.ended, 1003);
  EXPECT_EQ(report.path_time, 2.5);
  EXPECT_EQ(report.planned_clearance, 0.004);
  EXPECT_NEAR(report.model.mean, 3.5e-3 / 3.0, 1e-15);
  EXPECT_NEAR(report.model.largest, 2e-3, 1e-15);
  EXPECT_NEAR(report.model.at_end, std::sqrt(10.0) * 1e-3, 1e-15);
  EXPECT_NEAR(report.robot.mean, 8e-3 / 3.0, 1e-15);
  EXPECT_NEAR(report.robot.largest, 4e-3, 1e-15);
  EXPECT_NEAR(report.robot.at_end, 5e-3, 1e-15);
  EXPECT_NEAR(report.model_clearance, 0.001, 1e-15);
  EXPECT_NEAR(report.robot_clearance, 0.001, 1e-15);
  EXPECT_EQ(report.contact_ticks, 2U);
  EXPECT_EQ(report.contact_points, 5U);
}

TEST(ExecutionTally, ATipThatIsNoPlaceIsWorseThanAny) {
  for (const bool is_robot : {false, true}) {
    ExecutionTally tally;
    tally.start(70, plan(), /*on_robot=*/true);
    tally.begin(1000);
    ExecutionSample nowhere = sample(0.012, 0.0001, 0.001);
    (is_robot ? nowhere.robot_B : nowhere.model_B)[1] = std::nan("");
    tally.add(nowhere);
    EXPECT_FALSE(tally.deviation() <= 1.0);
    EXPECT_FALSE(tally.distanceToGoal() <= 1.0);
  }
}

/** Behind the path's end its last point is the tip's place on the path, and errors from there count as before. */
TEST(ExecutionTally, TheHoldBehindThePathsEndCounts) {
  ExecutionTally tally;
  tally.start(70, plan(), /*on_robot=*/true);
  tally.begin(1000);
  tally.add(sample(0.012, 0.0001, 0.001));  // under way: model 0.5 mm, robot 1 mm off the path
  tally.add(sample(0.0, 0.0004, 0.005));    // at the goal: 2 mm, 5 mm
  EXPECT_NEAR(tally.deviation(), 0.005, 1e-15);
  tally.add(sample(0.0, 0.0001, 0.0));  // 0.5 mm, 0 mm
  const ExecutionReport report = tally.finish(ExecutionEnd::kFinished, 1003, 1.0);
  EXPECT_NEAR(report.model.mean, 1e-3, 1e-15);
  EXPECT_NEAR(report.model.largest, 2e-3, 1e-15);
  EXPECT_NEAR(report.model.at_end, 0.5e-3, 1e-15);
  EXPECT_NEAR(report.robot.mean, 2e-3, 1e-15);
  EXPECT_NEAR(report.robot.largest, 5e-3, 1e-15);
  EXPECT_EQ(report.robot.at_end, 0.0);
}

TEST(ExecutionTally, LeavesOutARobotThatDoesNotMove) {
  ExecutionTally tally;
  tally.start(1, plan(), /*on_robot=*/false);
  tally.begin(5);
  tally.add(sample(0.0, 0.0002, 0.5));
  EXPECT_NEAR(tally.deviation(), 1e-3, 1e-15);
  EXPECT_NEAR(tally.distanceToGoal(), 1e-3, 1e-15);
  const ExecutionReport report = tally.finish(ExecutionEnd::kReleased, 6, 0.25);
  EXPECT_EQ(report.robot.largest, 0.0);
  EXPECT_NEAR(report.model_clearance, 0.002, 1e-15);
  EXPECT_EQ(report.robot_clearance, 0.0);
  EXPECT_EQ(report.progress, 0.25);
}

TEST(ExecutionTally, OfOneThatNeverBeganHasNoFigures) {
  ExecutionTally tally;
  tally.start(1, plan(), true);
  tally.begin(5);
  tally.add(sample(0.0, 0.1, 0.1, 3));
  tally.start(2, plan(), true);  // a new start: nothing of the first one is left
  const ExecutionReport report = tally.finish(ExecutionEnd::kNoPedal, 9, 0.0);
  EXPECT_EQ(report.id, 2U);
  EXPECT_EQ(report.started, -1);
  EXPECT_EQ(report.ended, 9);
  EXPECT_EQ(report.model.mean, 0.0);
  EXPECT_EQ(report.model.largest, 0.0);
  EXPECT_EQ(report.contact_ticks, 0U);
  EXPECT_EQ(report.model_clearance, 0.0);
  EXPECT_EQ(report.robot_clearance, 0.0);
  EXPECT_EQ(tally.deviation(), 0.0);
}

TEST(ExecutionTally, GivesTheMostContactPointsNotTheLast) {
  ExecutionTally tally;
  tally.start(70, plan(), /*on_robot=*/true);
  tally.begin(1000);
  for (const std::uint32_t contacts : {5U, 2U, 0U})
    tally.add(sample(0.012, 0.0001, 0.001, contacts));
  EXPECT_EQ(tally.finish(ExecutionEnd::kFinished, 1003, 1.0).contact_points, 5U);
}

}  // namespace
}  // namespace raven2_trainer::control
