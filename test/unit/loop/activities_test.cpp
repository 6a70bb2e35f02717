#include "loop/activity/activities.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "loop/plan_cancelled.h"
#include "support/activity_stage.h"

// Tests planning, trial and execution on a stage. Their events change the mode by the mode table; the test is the
// planner. The last test asks all activities, in each mode.

namespace raven2_trainer::loop {
namespace {

using control::Event;

constexpr double kPathLength = 0.05;  // [rad] of the shoulder
constexpr std::uint32_t kId = kOwnRequestIds + 1;

class ActivitiesTest : public raven2_trainer::testing::ActivityStage {
 protected:
  explicit ActivitiesTest(const TrainerConfig& of_stage = raven2_trainer::testing::packagedConfig())
      : ActivityStage(of_stage) {
    modes.state = &stage.state;
    stage.state.mode = Mode::kPedalUp;
  }

  static Request requestOf(RequestKind kind, Arm arm = Arm::kGold, bool on_robot = false) {
    Request request;
    request.kind = kind;
    request.arm = arm;
    request.id = kId;
    request.on_robot = on_robot ? 1 : 0;
    return request;
  }

  /** Answers the oldest plan request. @return the request. */
  PlanRequest answerPlan(PlanStatus status = PlanStatus::kSuccess) {
    PlanRequest asked;
    EXPECT_TRUE(shared->plan_requests.tryPop(&asked));
    PlanResult plan;
    plan.id = asked.id;
    plan.status = status;
    plan.arm = asked.arm;
    plan.waypoint_count = 2;
    plan.waypoints = {asked.start, asked.start};
    plan.waypoints[1][kShoulder] += kPathLength;
    plan.arrival[1] = 0.4;
    plan.clearance = 0.002;
    plan.robot_follows = 1;
    EXPECT_TRUE(shared->plan_results.tryPush(plan));
    planning.takeResults();
    return asked;
  }

  /** Plans for `arm`. The model begins to show the path. */
  void plan(Arm arm = Arm::kGold) {
    ASSERT_EQ(planning.request(requestOf(RequestKind::kPlan, arm)), PlanningAnswer::kAccepted);
    answerPlan();
    ASSERT_EQ(stage.mode(), Mode::kTracking);
    planning.enter(Mode::kPlanning);
  }

  /** Plans for `arm`, and arms the plan. */
  void arm(Arm arm = Arm::kGold, bool on_robot = false) {
    plan(arm);
    ASSERT_EQ(execution.request(requestOf(RequestKind::kExecutePlan, arm, on_robot)), PlanningAnswer::kAccepted);
    ASSERT_EQ(stage.mode(), Mode::kArmed);
    execution.enter(Mode::kTracking);
  }

  /** The pedal goes down on what is armed. */
  void press() {
    ASSERT_TRUE(execution.press());
    modes.raise(Event::kPedalPressed);
    ASSERT_EQ(stage.mode(), Mode::kExecuting);
    execution.enter(Mode::kArmed);
  }

  /** Executes until the mode changes. */
  void execute() {
    for (int i = 0; i < 5000 && stage.mode() == Mode::kExecuting; ++i)
      tick(&execution);
  }

  ExecutionReport report() {
    ExecutionReport report;
    EXPECT_TRUE(shared->execution_answers.tryPop(&report));
    return report;
  }

  /** Records a trial in which both hands move for `ticks`. The trial is ready at the end. */
  void tryIt(int ticks) {
    ASSERT_EQ(trial.request(requestOf(RequestKind::kBeginTrial)), PlanningAnswer::kAccepted);
    modes.raise(Event::kPedalPressed);
    trial.enter(Mode::kTrialHeld);
    for (int i = 0; i < ticks; ++i) {
      for (const Arm each : kArms)
        move(each, {0.0, 0.0, -20e-6});
      tick(&trial);
      trial.keep();
    }
    ASSERT_EQ(trial.request(requestOf(RequestKind::kEndTrial)), PlanningAnswer::kAccepted);
    ASSERT_EQ(stage.mode(), Mode::kTrialReady);
  }

  double shoulder(Arm arm) { return stage.arms.joints(arm)[kShoulder]; }

  Planning planning{raven, scene, &stage};
  Trial trial{raven, scene, 1.0, &stage};
  Execution execution{&planning, &trial, &stage};
};

TEST_F(ActivitiesTest, APlanOfEitherArmIsComputedAndShown) {
  for (const Arm arm : kArms) {
    const double before = shoulder(arm), other = shoulder(otherArm(arm));
    const PerArm<JointArray> now = stage.arms.joints();
    ASSERT_EQ(planning.request(requestOf(RequestKind::kPlan, arm)), PlanningAnswer::kAccepted);
    EXPECT_EQ(stage.mode(), Mode::kPlanning);
    EXPECT_EQ(planning.request(requestOf(RequestKind::kPlan, arm)), PlanningAnswer::kNotNow) << "one is computed";
    const PlanRequest asked = answerPlan();
    EXPECT_EQ(asked.arm, arm);
    EXPECT_EQ(asked.start, at(now, arm));
    EXPECT_EQ(asked.other, at(now, otherArm(arm)));
    PlanResult answer;
    ASSERT_TRUE(shared->plan_answers.tryPop(&answer));
    EXPECT_EQ(answer.id, kId);
    ASSERT_EQ(stage.mode(), Mode::kTracking);
    planning.enter(Mode::kPlanning);
    for (int i = 0; i < 600; ++i)
      tick(&planning);
    EXPECT_NEAR(shoulder(arm), before + kPathLength, 5e-3);
    EXPECT_NEAR(shoulder(otherArm(arm)), other, 1e-3) << "the other arm holds";
  }
}

class OpenLoopTest : public ActivitiesTest, public ::testing::WithParamInterface<Arm> {
 protected:
  OpenLoopTest() : ActivitiesTest(openLoop()) {}
  static TrainerConfig openLoop() {
    TrainerConfig config = raven2_trainer::testing::packagedConfig();
    config.execution.drive = ExecutionDrive::kOpenLoop;
    return config;
  }
};

INSTANTIATE_TEST_SUITE_P(Arms, OpenLoopTest, ::testing::ValuesIn(kArms));

TEST_P(OpenLoopTest, TheExecutedArmAloneIsNotCorrected) {
  arm(GetParam());
  press();
  for (int i = 0; i < 100; ++i)
    tick(&execution);
  for (const Arm each : kArms) {
    JointArray q = stage.arms.joints(each);
    q[kInsertion] += 0.002;
    stage.arms.world().setJointState(each, q, JointArray{});
  }
  for (int i = 0; i < 200; ++i)
    tick(&execution);
  ASSERT_EQ(stage.mode(), Mode::kExecuting);
  for (const Arm each : kArms) {
    const double off = stage.arms.joints(each)[kInsertion] - wanted(each, kInsertion);
    EXPECT_NEAR(off, each == GetParam() ? 0.002 : 0.0, 0.0005) << name(each);
  }
}

TEST_F(ActivitiesTest, AFailedPlanEndsPlanning) {
  ASSERT_EQ(planning.request(requestOf(RequestKind::kPlan)), PlanningAnswer::kAccepted);
  answerPlan(PlanStatus::kNoPath);
  EXPECT_EQ(stage.mode(), Mode::kPedalUp);
  EXPECT_EQ(planning.store().state().status, PlanningStatus::kIdle);
}

TEST_F(ActivitiesTest, NobodyFollowsACancelledPlan) {
  ASSERT_EQ(planning.request(requestOf(RequestKind::kPlan)), PlanningAnswer::kAccepted);
  planning.settle(Mode::kPedalUp, Event::kPlanCancelled);
  stage.state.mode = Mode::kPedalUp;
  EXPECT_TRUE(planCancelled(shared.get(), 1).load()) << "the planner stops";
  answerPlan();
  EXPECT_EQ(stage.mode(), Mode::kPedalUp);
  PlanResult answer;
  ASSERT_TRUE(shared->plan_answers.tryPop(&answer));
  EXPECT_EQ(answer.status, PlanStatus::kCancelled);
}

TEST_F(ActivitiesTest, NoMorePlansAreUnderWayThanTheQueueHolds) {
  for (std::size_t i = 0; i <= kMaxPlansUnderWay; ++i) {
    const bool fits = i < kMaxPlansUnderWay;
    EXPECT_EQ(planning.request(requestOf(RequestKind::kPlan)),
              fits ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow);
    planning.settle(Mode::kPedalUp, Event::kPlanCancelled);
    stage.state.mode = Mode::kPedalUp;
  }
  PlanRecord record;
  ASSERT_TRUE(shared->plan_records.tryPop(&record));
  EXPECT_EQ(record.refused, 1);
}

TEST_F(ActivitiesTest, AfterAPathTheModelIsOnTheRobotBeforeTheNextPlan) {
  showRobot();
  const double begin = shoulder(Arm::kGold);
  plan();
  for (int i = 0; i < 600; ++i)
    tick(&planning);
  ASSERT_GT(shoulder(Arm::kGold), begin + 0.5 * kPathLength);
  planning.leave(Mode::kPlanning);
  EXPECT_NEAR(shoulder(Arm::kGold), begin, 1e-9);
}

TEST_F(ActivitiesTest, ATrialKeepsTheTicksWithThePedalDown) {
  const PerArm<JointArray> before = stage.arms.wanted();
  trial.keep();
  tryIt(50);
  trial.keep();
  EXPECT_EQ(trial.store().ticks(), 50u);
  EXPECT_TRUE(trial.rehearses());
  EXPECT_EQ(trial.request(requestOf(RequestKind::kBeginTrial)), PlanningAnswer::kNotNow);
  for (const Arm each : kArms)
    EXPECT_GT(std::abs(wanted(each, kInsertion) - at(before, each)[kInsertion]), 2e-4);
}

TEST_F(ActivitiesTest, AFullTapeEndsTheTrial) {
  Trial brief(raven, scene, 0.01, &stage);
  ASSERT_EQ(brief.request(requestOf(RequestKind::kBeginTrial)), PlanningAnswer::kAccepted);
  modes.raise(Event::kPedalPressed);
  for (int i = 0; i < 20 && stage.mode() == Mode::kTrial; ++i) {
    tick(&brief);
    brief.keep();
  }
  EXPECT_EQ(stage.mode(), Mode::kTrialReady);
  EXPECT_EQ(brief.store().ticks(), 10u);
}

TEST_F(ActivitiesTest, ADiscardedTrialIsDeletedAndItsSceneSetBack) {
  tryIt(5);
  stage.pedal.is_down = true;
  EXPECT_EQ(trial.request(requestOf(RequestKind::kDiscardTrial)), PlanningAnswer::kNotNow);
  stage.pedal.is_down = false;
  EXPECT_EQ(trial.request(requestOf(RequestKind::kDiscardTrial)), PlanningAnswer::kAccepted);
  trial.endRehearsal();
  EXPECT_TRUE(trial.rehearses()) << "the model returns first";
  modes.raise(Event::kReturned);
  trial.settle(Mode::kPedalUp, Event::kReturned);
  trial.endRehearsal();
  EXPECT_FALSE(trial.rehearses());
  EXPECT_FALSE(trial.store().isOpen());
}

TEST_F(ActivitiesTest, ARepetitionIsRefusedWithItsReason) {
  const Request repeat = requestOf(RequestKind::kRepeatTrial);
  EXPECT_EQ(trial.request(repeat), PlanningAnswer::kNotNow) << "no trial is ready";
  tryIt(0);
  EXPECT_EQ(trial.request(repeat), PlanningAnswer::kNoPlan);
  stage.state.mode = Mode::kPedalUp;
  tryIt(5);
  EXPECT_EQ(trial.request(requestOf(RequestKind::kRepeatTrial, Arm::kGold, true)), PlanningAnswer::kNoRobot);
  stage.pedal.is_down = true;
  EXPECT_EQ(trial.request(repeat), PlanningAnswer::kNotNow);
  stage.pedal.is_down = false;
  showRobot(0.2);
  EXPECT_EQ(trial.request(repeat), PlanningAnswer::kMoved);
}

TEST_F(ActivitiesTest, ARepetitionMovesBothArmsAsTheTrialDid) {
  tryIt(200);
  const PerArm<JointArray> ended = stage.arms.wanted();
  ASSERT_EQ(trial.request(requestOf(RequestKind::kRepeatTrial)), PlanningAnswer::kAccepted);
  ASSERT_EQ(stage.mode(), Mode::kReturning);
  EXPECT_TRUE(execution.repeats());
  for (const Arm each : kArms)
    stage.arms.world().setJointState(each, at(trial.store().start(), each), JointArray{});
  trial.armRepeat();
  ASSERT_EQ(stage.mode(), Mode::kArmed);
  execution.enter(Mode::kReturning);
  press();
  execute();
  EXPECT_EQ(modes.events.back(), Event::kRepeatShown);
  EXPECT_EQ(stage.mode(), Mode::kTrialReady);
  EXPECT_EQ(report().end, ExecutionEnd::kFinished);
  for (const Arm each : kArms)
    EXPECT_NEAR(wanted(each, kInsertion), at(ended, each)[kInsertion], 1e-4);
}

TEST_F(ActivitiesTest, AnExecutionIsRefusedWithItsReason) {
  const Request execute = requestOf(RequestKind::kExecutePlan);
  EXPECT_EQ(execution.request(execute), PlanningAnswer::kNoPlan);
  plan();
  EXPECT_EQ(execution.request(requestOf(RequestKind::kExecutePlan, Arm::kGold, true)), PlanningAnswer::kNoRobot);
  stage.pedal.is_down = true;
  EXPECT_EQ(execution.request(execute), PlanningAnswer::kNotNow);
  stage.pedal.is_down = false;
  showRobot(0.2);
  EXPECT_EQ(execution.request(execute), PlanningAnswer::kMoved);
  EXPECT_EQ(stage.mode(), Mode::kTracking);
}

TEST_F(ActivitiesTest, APlanOfEitherArmIsExecutedByTheModel) {
  for (const Arm each : kArms) {
    stage.state.mode = Mode::kPedalUp;
    const double begin = shoulder(each), other = shoulder(otherArm(each));
    arm(each);
    press();
    execute();
    EXPECT_EQ(modes.events.back(), Event::kTrialEnded) << "the robot did not move";
    const ExecutionReport done = report();
    EXPECT_EQ(done.end, ExecutionEnd::kFinished);
    EXPECT_EQ(done.arm, each);
    EXPECT_EQ(done.id, kId);
    EXPECT_NEAR(shoulder(each), begin + kPathLength, 5e-3);
    EXPECT_NEAR(shoulder(otherArm(each)), other, 1e-3) << "the other arm holds";
  }
}

TEST_F(ActivitiesTest, TheReleasedPedalEndsAnExecution) {
  arm();
  press();
  for (int i = 0; i < 1000 && planning.store().state().progress < 0.5; ++i)
    tick(&execution);
  ASSERT_EQ(stage.mode(), Mode::kExecuting);
  execution.release();
  const ExecutionReport done = report();
  EXPECT_EQ(done.end, ExecutionEnd::kReleased);
  EXPECT_GE(done.progress, 0.5);
  EXPECT_NE(stage.mode(), Mode::kExecuting);
}

TEST_F(ActivitiesTest, TheEventThatEndsAnExecutionIsItsReason) {
  for (const auto& [event, end] :
       {std::pair(Event::kEmergencyStop, ExecutionEnd::kEStop), std::pair(Event::kTimeSlip, ExecutionEnd::kTimeSlip),
        std::pair(Event::kPlanCancelled, ExecutionEnd::kCancelled)}) {
    stage.state.mode = Mode::kPedalUp;
    arm();
    press();
    execution.settle(control::nextMode(stage.mode(), event), event);
    EXPECT_EQ(report().end, end);
  }
}

TEST_F(ActivitiesTest, ACancelledPlanIsForgotten) {
  arm();
  ASSERT_EQ(planning.store().state().status, PlanningStatus::kArmed);
  EXPECT_EQ(execution.request(requestOf(RequestKind::kCancelPlan)), PlanningAnswer::kAccepted);
  EXPECT_EQ(stage.mode(), Mode::kPedalUp);
  EXPECT_EQ(planning.store().state().status, PlanningStatus::kIdle);
  EXPECT_EQ(execution.request(requestOf(RequestKind::kExecutePlan)), PlanningAnswer::kNoPlan);
}

TEST_F(ActivitiesTest, APressOnArmsThatMovedDisarms) {
  arm();
  showRobot(0.2);
  EXPECT_FALSE(execution.press());
  EXPECT_EQ(report().end, ExecutionEnd::kMoved);
  EXPECT_EQ(stage.mode(), Mode::kPedalUp);
}

TEST_F(ActivitiesTest, APressWithoutTheRobotThatWasAskedForDisarms) {
  showRobot();
  arm(Arm::kGold, /*on_robot=*/true);
  EXPECT_TRUE(execution.movesRobot());
  stage.state.engaged = 0;
  EXPECT_FALSE(execution.press());
  EXPECT_EQ(report().end, ExecutionEnd::kRobotLost);
}

TEST_F(ActivitiesTest, AnArmedPlanWaitsForThePedalOnlySoLong) {
  arm();
  const int limit = static_cast<int>(config.execution.pedal_timeout / kTickSeconds) + 2;
  for (int i = 0; i < limit && stage.mode() == Mode::kArmed; ++i)
    execution.supervise();
  EXPECT_EQ(stage.mode(), Mode::kPedalUp);
  EXPECT_EQ(report().end, ExecutionEnd::kNoPedal);
}

// ---- all together ------------------------------------------------------------------------------------------------

TEST_F(ActivitiesTest, AReplayBeginsInTheModesOfTheTable) {
  Activities activities(raven, scene, stage.config.live_camera, 1.0, &stage);
  for (std::size_t mode = 0; mode < kModeCount; ++mode) {
    stage.state.mode = static_cast<Mode>(mode);
    Request begin;
    begin.kind = RequestKind::kBeginReplay;
    begin.id = kOwnRequestIds + 1;
    begin.plan = static_cast<std::uint32_t>(mode) + 1;
    EXPECT_TRUE(activities.serve(begin));
    RequestAnswer answer;
    ASSERT_TRUE(shared->answers.tryPop(&answer));
    const bool is_begun = answer.answer == PlanningAnswer::kAccepted;
    EXPECT_EQ(is_begun, traitsOf(static_cast<Mode>(mode)).may_replay) << kModeNames[mode];
    EXPECT_EQ(stage.mode(), is_begun ? Mode::kReplaying : static_cast<Mode>(mode));
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
