#include "ros/planning/move_arm_task.h"

#include <gtest/gtest.h>

#include "fake_loop.h"
#include "ros/planning/planning_messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** A task, and a loop that plans and arms as the real one does. */
class MoveArmTaskTest : public ::testing::Test {
 protected:
  MoveArmTaskTest() {
    loop.on_request = [this](const Request& request) { serve(request); };
  }

  void serve(const Request& request) {
    loop.answer(request, answer);
    if (answer != PlanningAnswer::kAccepted) return;
    if (request.kind == RequestKind::kPlan) set(PlanningStatus::kPlanning, request.id);
    if (request.kind == RequestKind::kExecutePlan) set(PlanningStatus::kArmed, loop.planning.plan);
    if (request.kind == RequestKind::kCancelPlan) cancelAll();
  }

  void cancelAll() {
    if (loop.planning.status == PlanningStatus::kPlanning) loop.plan(loop.planning.plan, PlanStatus::kCancelled);
    if (loop.planning.status == PlanningStatus::kArmed) loop.report(loop.seen.back().id - 1, ExecutionEnd::kCancelled);
    set(PlanningStatus::kIdle, 0);
  }

  void set(PlanningStatus status, std::uint32_t plan) {
    loop.planning.status = status;
    loop.planning.plan = plan;
  }

  void begin(bool on_robot = true) { task.begin(requestOf(RequestKind::kPlan), on_robot); }

  void planEnds(PlanStatus status) {
    loop.plan(loop.planning.plan, status);
    set(status == PlanStatus::kSuccess ? PlanningStatus::kReady : PlanningStatus::kIdle, loop.planning.plan);
    loop.tick();
  }

  void executionEnds(ExecutionEnd end) {
    set(PlanningStatus::kReady, loop.planning.plan);
    loop.report(loop.seen.back().id, end);
    loop.tick();
  }

  FakeLoop loop;
  PlanningClient client{&loop.shared, [this] { loop.tick(); }};
  MoveArmTask task{&client};
  PlanningAnswer answer{PlanningAnswer::kAccepted};
};

TEST_F(MoveArmTaskTest, ThePlanIsExecutedAndReported) {
  begin();
  EXPECT_FALSE(task.look());
  const std::uint32_t plan = loop.planning.plan;
  planEnds(PlanStatus::kSuccess);
  EXPECT_FALSE(task.look());
  ASSERT_EQ(loop.seen.size(), 2U);
  EXPECT_EQ(loop.seen[1].kind, RequestKind::kExecutePlan);
  EXPECT_EQ(loop.seen[1].plan, plan);
  EXPECT_EQ(loop.seen[1].on_robot, 1);
  executionEnds(ExecutionEnd::kFinished);
  ASSERT_TRUE(task.look());
  EXPECT_EQ(task.outcome().code, ErrorCode::kSuccess);
  EXPECT_EQ(task.outcome().status, "finished");
  EXPECT_EQ(task.outcome().plan.id, plan);
  EXPECT_EQ(task.outcome().report.id, loop.seen[1].id);
  EXPECT_FALSE(task.outcome().was_cancelled);
}

TEST_F(MoveArmTaskTest, TheModelAloneIfTheRobotWasNotAskedFor) {
  begin(false);
  planEnds(PlanStatus::kSuccess);
  task.look();
  EXPECT_EQ(loop.seen.at(1).on_robot, 0);
}

TEST_F(MoveArmTaskTest, WhatTheLoopRefusesIsOverAtOnce) {
  answer = PlanningAnswer::kNotNow;
  begin();
  EXPECT_TRUE(task.isOver());
  EXPECT_EQ(task.outcome().code, ErrorCode::kInvalidRobotState);
  EXPECT_EQ(task.outcome().status, "not_now");
}

TEST_F(MoveArmTaskTest, APlanThatFailedIsNotExecuted) {
  begin();
  planEnds(PlanStatus::kGoalInCollision);
  ASSERT_TRUE(task.look());
  EXPECT_EQ(task.outcome().code, ErrorCode::kGoalInCollision);
  EXPECT_EQ(task.outcome().status, "goal_in_collision");
  EXPECT_EQ(loop.count(RequestKind::kExecutePlan), 0);
}

TEST_F(MoveArmTaskTest, APlanTheRobotCannotFollowEndsIt) {
  begin();
  answer = PlanningAnswer::kRobotCannotFollow;
  planEnds(PlanStatus::kSuccess);
  ASSERT_TRUE(task.look());
  EXPECT_EQ(task.outcome().code, ErrorCode::kInvalidMotionPlan);
  EXPECT_EQ(task.outcome().status, "robot_cannot_follow");
  EXPECT_EQ(task.outcome().report.id, 0U);
}

TEST_F(MoveArmTaskTest, AReleasedPedalIsNoCancellationByTheClient) {
  begin();
  planEnds(PlanStatus::kSuccess);
  task.look();
  executionEnds(ExecutionEnd::kReleased);
  ASSERT_TRUE(task.look());
  EXPECT_EQ(task.outcome().code, ErrorCode::kPreempted);
  EXPECT_FALSE(task.outcome().was_cancelled);
}

TEST_F(MoveArmTaskTest, CancellingWhilePlanningAndWhileArmed) {
  for (const bool is_planned : {false, true}) {
    begin();
    if (is_planned) {
      planEnds(PlanStatus::kSuccess);
      EXPECT_FALSE(task.look());
    }
    task.cancel();
    ASSERT_TRUE(task.isOver());
    EXPECT_TRUE(task.outcome().was_cancelled);
    EXPECT_EQ(task.outcome().code, ErrorCode::kPreempted);
    EXPECT_EQ(task.outcome().report.id != 0, is_planned) << "an execution is reported if there was one";
    EXPECT_EQ(loop.planning.status, PlanningStatus::kIdle);
  }
  EXPECT_EQ(loop.count(RequestKind::kCancelPlan), 2);
}

TEST_F(MoveArmTaskTest, APlanThatCameTogetherWithTheCancellationIsNotExecuted) {
  begin();
  planEnds(PlanStatus::kSuccess);
  task.cancel();
  ASSERT_TRUE(task.isOver());
  EXPECT_EQ(task.outcome().code, ErrorCode::kPreempted);
  EXPECT_TRUE(task.outcome().was_cancelled);
  EXPECT_NE(task.outcome().plan.id, 0U);
  EXPECT_EQ(loop.count(RequestKind::kExecutePlan), 0);
  EXPECT_EQ(loop.planning.status, PlanningStatus::kIdle);
}

TEST_F(MoveArmTaskTest, AnExecutionThatFinishedTogetherWithTheCancellationIsASuccess) {
  begin();
  planEnds(PlanStatus::kSuccess);
  task.look();
  executionEnds(ExecutionEnd::kFinished);
  task.cancel();
  EXPECT_EQ(task.outcome().code, ErrorCode::kSuccess);
  EXPECT_FALSE(task.outcome().was_cancelled);
}

TEST_F(MoveArmTaskTest, ACancellationThatNobodyTookIsNotCalledOne) {
  begin();
  loop.on_request = [](const Request&) {};
  task.cancel();
  EXPECT_TRUE(task.isOver());
  EXPECT_EQ(task.outcome().code, ErrorCode::kCommunicationFailure);
}

TEST_F(MoveArmTaskTest, CancellingLeavesTheOrderOfSomebodyElseAlone) {
  begin();
  set(PlanningStatus::kPlanning, 4711);  // a newer request
  loop.tell();
  task.cancel();
  EXPECT_TRUE(task.isOver());
  EXPECT_TRUE(task.outcome().was_cancelled);
  EXPECT_EQ(loop.count(RequestKind::kCancelPlan), 0);
}

TEST_F(MoveArmTaskTest, AnOrderWhosePlaceAnotherOneTookEndsWithItsOwnAnswer) {
  begin();
  const std::uint32_t own = loop.planning.plan;
  set(PlanningStatus::kPlanning, 4711);
  loop.plan(4711, PlanStatus::kSuccess);
  loop.tell();
  EXPECT_FALSE(task.look());
  loop.plan(own, PlanStatus::kCancelled);
  EXPECT_TRUE(task.look());
  EXPECT_EQ(task.outcome().code, ErrorCode::kPreempted);
}

TEST_F(MoveArmTaskTest, AnOrderThatIsWorkedOnNeverEndsByItself) {
  begin();
  for (int look = 0; look < 1000; ++look)
    ASSERT_FALSE(task.look());
  planEnds(PlanStatus::kSuccess);
  for (int look = 0; look < 1000; ++look)
    ASSERT_FALSE(task.look());
}

TEST_F(MoveArmTaskTest, TheResultOfTheActionSaysAllOfIt) {
  MoveArmTask::Outcome outcome;
  outcome.code = ErrorCode::kTimedOut;
  outcome.status = "no_pedal";
  outcome.plan.id = 3;
  outcome.plan.arm = Arm::kGreen;
  outcome.plan.cost = 1.5;
  outcome.plan.planning_time = 0.25;
  outcome.report.id = 4;
  outcome.report.end = ExecutionEnd::kNoPedal;
  const MoveArmResult result = moveArmResult(outcome, ros::Time(9.0));
  EXPECT_EQ(result.error_code, -6);
  EXPECT_EQ(result.status, "no_pedal");
  EXPECT_EQ(result.plan, 3U);
  EXPECT_EQ(result.arm, "green");
  EXPECT_EQ(result.cost, 1.5);
  EXPECT_EQ(result.planning_time, 0.25);
  EXPECT_EQ(result.report.execution, 4U);
  EXPECT_EQ(result.report.end, "no_pedal");
  EXPECT_EQ(moveArmResult({}, ros::Time(9.0)).arm, "") << "without a plan there is no arm";
}

TEST_F(MoveArmTaskTest, EachOrderStartsWithNoOutcome) {
  begin();
  planEnds(PlanStatus::kGoalInCollision);
  ASSERT_TRUE(task.look());
  begin();
  EXPECT_EQ(task.outcome().plan.id, 0U) << "the failed plan belongs to the order before";
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
