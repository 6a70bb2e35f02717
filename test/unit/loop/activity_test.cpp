#include "loop/activity/activity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "loop/activity/camera.h"
#include "loop/activity/goal_selection.h"
#include "loop/activity/hold.h"
#include "loop/activity/replay.h"
#include "loop/activity/returning.h"
#include "loop/activity/teleoperation.h"
#include "support/activity_stage.h"

// Tests each activity alone on a stage; planning, trial and execution: activities_test.cpp.

namespace raven2_trainer::loop {
namespace {

using control::Event;

class ActivityTest : public raven2_trainer::testing::ActivityStage {};

TEST_F(ActivityTest, HoldFollowsTheRobotWithThePedalUp) {
  Hold hold(&stage);
  stage.state.mode = Mode::kPedalUp;
  showRobot(0.02);
  const double begin = wanted(Arm::kGold, kShoulder);
  for (int i = 0; i < 300; ++i)
    tick(&hold);
  EXPECT_NEAR(stage.arms.joints(Arm::kGold)[kShoulder], begin + 0.02, 2e-3);
  EXPECT_TRUE(modes.events.empty());
}

TEST_F(ActivityTest, HoldStandsStillWhenStopped) {
  Hold hold(&stage);
  stage.state.mode = Mode::kStopped;
  showRobot(0.02);
  const double begin = wanted(Arm::kGold, kShoulder);
  for (int i = 0; i < 300; ++i)
    tick(&hold);
  EXPECT_NEAR(stage.arms.joints(Arm::kGold)[kShoulder], begin, 2e-3);
}

TEST_F(ActivityTest, HoldGoesBackToARobotFromWhichTheModelWentAway) {
  Hold hold(&stage);
  stage.state.mode = Mode::kPedalUp;
  stage.arms.leaveRobot();
  hold.supervise();
  EXPECT_TRUE(modes.events.empty()) << "there is no robot to return to";
  showRobot();
  hold.supervise();
  EXPECT_EQ(modes.events, std::vector<Event>{Event::kReturnWanted});
}

TEST_F(ActivityTest, AStopIsClearedOnlyWithThePedalUp) {
  Hold hold(&stage);
  Request stop, clear;
  stop.kind = RequestKind::kEmergencyStop;
  clear.kind = RequestKind::kClearStop;
  EXPECT_EQ(hold.request(clear), PlanningAnswer::kNotNow) << "nobody asked for a stop";
  EXPECT_EQ(hold.request(stop), PlanningAnswer::kAccepted);
  EXPECT_TRUE(stage.stop_asked);
  stage.pedal.is_down = true;
  EXPECT_EQ(hold.request(clear), PlanningAnswer::kNotNow);
  stage.pedal.is_down = false;
  EXPECT_EQ(hold.request(clear), PlanningAnswer::kAccepted);
  EXPECT_FALSE(stage.stop_asked);
  EXPECT_EQ(modes.events, (std::vector<Event>{Event::kEmergencyStop, Event::kStopCleared}));
}

TEST_F(ActivityTest, ClearingOurStopDoesNotClearTheRobots) {
  Hold hold(&stage);
  Request clear;
  clear.kind = RequestKind::kClearStop;
  showRobot();
  stage.stop_asked = stage.stopped_by_robot = true;
  EXPECT_EQ(hold.request(clear), PlanningAnswer::kAccepted);
  EXPECT_TRUE(modes.events.empty());
}

TEST_F(ActivityTest, TeleoperationMovesTheArmOfEachHand) {
  for (const Arm arm : kArms) {
    Teleoperation teleoperation(&stage);
    stage.state.mode = Mode::kTeleoperating;
    teleoperation.enter(Mode::kPedalUp);
    const PerArm<JointArray> before = stage.arms.wanted();
    stage.increments = {};
    move(arm, {0.0, 0.0, -1e-3});
    teleoperation.tick();
    const Arm other = otherArm(arm);
    EXPECT_GT(std::abs(wanted(arm, kInsertion) - at(before, arm)[kInsertion]), 5e-4);
    EXPECT_LT(std::abs(wanted(other, kInsertion) - at(before, other)[kInsertion]), 1e-4);
    EXPECT_EQ(stage.state.commands_used, 1u);
  }
}

TEST_F(ActivityTest, TeleoperationWaitsForARobotThatIsLinkedAndNotYetEngaged) {
  Teleoperation teleoperation(&stage);
  stage.state.mode = Mode::kTeleoperating;
  showRobot();
  stage.robot.link(true);
  const PerArm<JointArray> before = stage.arms.wanted();
  move(Arm::kGold, {0.0, 0.0, -50e-6});
  teleoperation.tick();
  EXPECT_EQ(stage.arms.wanted(), before);
  EXPECT_EQ(stage.state.commands_used, 0u);
}

TEST_F(ActivityTest, SimulationBeginsAndEndsWithThePedalUp) {
  Teleoperation teleoperation(&stage);
  Request begin, end;
  begin.kind = RequestKind::kBeginSimulation;
  end.kind = RequestKind::kEndSimulation;
  stage.pedal.is_down = true;
  EXPECT_EQ(teleoperation.request(begin), PlanningAnswer::kNotNow);
  EXPECT_EQ(teleoperation.request(end), PlanningAnswer::kNotNow);
  stage.pedal.is_down = false;
  EXPECT_EQ(teleoperation.request(begin), PlanningAnswer::kAccepted);
  EXPECT_EQ(teleoperation.request(end), PlanningAnswer::kAccepted);
  EXPECT_EQ(modes.events, (std::vector<Event>{Event::kSimulationWanted, Event::kSimulationEnded}));
}

TEST_F(ActivityTest, TheCameraMovesByTheMeanOfBothHandsAndTheArmsHold) {
  Camera camera(stage.config.live_camera, &stage);
  stage.state.mode = Mode::kCameraMoving;
  const CameraState begin = camera.state();
  const PerArm<JointArray> before = stage.arms.wanted();
  move(Arm::kGold, {0.0, 1e-3, 0.0});
  move(Arm::kGreen, {0.0, -1e-3, 0.0});
  camera.tick();
  EXPECT_EQ(camera.state().eye_W, begin.eye_W) << "the hands move in opposite directions";
  move(Arm::kGold, {0.0, 1e-3, 0.0});
  move(Arm::kGreen, {0.0, 1e-3, 0.0});
  camera.tick();
  EXPECT_NE(camera.state().eye_W, begin.eye_W);
  EXPECT_EQ(stage.arms.wanted(), before);
}

TEST_F(ActivityTest, TheCameraGoesBackToTheModeThatItCameFrom) {
  const std::vector<std::pair<Mode, Event>> pairs{
      {Mode::kPedalUp, Event::kCameraLeft},         {Mode::kTeleoperating, Event::kCameraLeft},
      {Mode::kSimulating, Event::kCameraLeftAlone}, {Mode::kSimulationHeld, Event::kCameraLeftAlone},
      {Mode::kTrial, Event::kCameraLeftOnTape},     {Mode::kTrialHeld, Event::kCameraLeftOnTape}};
  Camera camera(stage.config.live_camera, &stage);
  Request released;
  released.enabled = static_cast<std::uint8_t>(CameraPedal::kReleased);
  for (const auto& [from, event] : pairs) {
    stage.state.mode = Mode::kCameraMoving;
    camera.enter(from);
    modes.events.clear();
    EXPECT_EQ(camera.request(released), PlanningAnswer::kAccepted);
    EXPECT_EQ(modes.events, std::vector<Event>{event});
  }
}

TEST_F(ActivityTest, AReplayShowsItsFramesAndLeavesTheArmsAsTheyWere) {
  Replay replay(&stage);
  Request begin;
  begin.kind = RequestKind::kBeginReplay;
  begin.plan = 7;
  ASSERT_EQ(replay.request(begin), PlanningAnswer::kAccepted);
  EXPECT_EQ(replay.request(begin), PlanningAnswer::kNotNow) << "a second replay needs another number";
  const JointArray stood = stage.arms.joints(Arm::kGold);
  ReplayFrame frame{};
  frame.replay = 7;
  frame.q = stage.arms.joints();
  frame.q[0][kShoulder] += 0.1;
  ASSERT_TRUE(shared->replay_frames.tryPush(frame));
  stage.state.mode = Mode::kReplaying;
  tick(&replay);
  EXPECT_NEAR(stage.arms.joints(Arm::kGold)[kShoulder], stood[kShoulder] + 0.1, 1e-9);
  tick(&replay);
  EXPECT_NEAR(stage.arms.joints(Arm::kGold)[kShoulder], stood[kShoulder] + 0.1, 1e-9) << "the last frame stays";
  frame.is_last = 1;
  ASSERT_TRUE(shared->replay_frames.tryPush(frame));
  replay.supervise();
  EXPECT_EQ(modes.events.back(), Event::kReplayEnded);
  replay.leave(Mode::kPedalUp);
  EXPECT_NEAR(stage.arms.joints(Arm::kGold)[kShoulder], stood[kShoulder], 1e-9);
}

TEST_F(ActivityTest, APressEndsAReplayAndDoesNotEngage) {
  Replay replay(&stage);
  stage.pedal.is_down = true;
  replay.supervise();
  EXPECT_EQ(modes.events, std::vector<Event>{Event::kReplayEnded});
  EXPECT_TRUE(stage.pedal.was_down) << "the press that ended the replay is not a new press";
}

TEST_F(ActivityTest, ReturningBringsTheModelToTheRobot) {
  Trial trial(raven, scene, 1.0, &stage);
  Returning returning(config.planner, &trial, &stage);
  showRobot(0.1);
  stage.arms.leaveRobot();
  stage.state.mode = Mode::kReturning;
  returning.enter(Mode::kPedalUp);
  const double goal = stage.robot.joints()[0][kShoulder];
  for (int i = 0; i < 5000 && modes.events.empty(); ++i)
    tick(&returning);
  EXPECT_EQ(modes.events, std::vector<Event>{Event::kReturned});
  EXPECT_FALSE(stage.arms.isApart());
  EXPECT_NEAR(stage.arms.joints(Arm::kGold)[kShoulder], goal, 5e-3);
}

TEST_F(ActivityTest, ReturningFollowsARobotThatMovedMeanwhile) {
  Trial trial(raven, scene, 1.0, &stage);
  Returning returning(config.planner, &trial, &stage);
  showRobot(0.05);
  stage.arms.leaveRobot();
  stage.state.mode = Mode::kReturning;
  returning.enter(Mode::kPedalUp);
  for (int i = 0; i < 20; ++i)
    tick(&returning);
  showRobot(0.2);
  const double goal = stage.robot.joints()[0][kShoulder];
  for (int i = 0; i < 5000 && modes.events.empty(); ++i)
    tick(&returning);
  EXPECT_EQ(modes.events, std::vector<Event>{Event::kReturned});
  EXPECT_NEAR(stage.arms.joints(Arm::kGold)[kShoulder], goal, 5e-3);
}

TEST_F(ActivityTest, AGoalIsChosenWithOneArmThatComesBack) {
  Planning planning(raven, scene, &stage);
  GoalSelection selection(&planning, &stage);
  stage.state.mode = Mode::kChoosing;
  Request begin;
  begin.kind = RequestKind::kBeginPlanning;
  begin.arm = Arm::kGreen;
  ASSERT_EQ(selection.request(begin), PlanningAnswer::kAccepted);
  const PerArm<JointArray> stood = stage.arms.joints();
  for (int i = 0; i < 100; ++i) {
    move(Arm::kGold, {0.0, 0.0, -50e-6});
    move(Arm::kGreen, {0.0, 0.0, -50e-6});
    tick(&selection);
  }
  EXPECT_EQ(stage.arms.joints(Arm::kGold), stood[0]);
  EXPECT_NE(stage.arms.joints(Arm::kGreen), stood[1]);
  selection.leave(Mode::kPedalUp);
  EXPECT_EQ(stage.arms.joints(Arm::kGreen), stood[1]);
}

}  // namespace
}  // namespace raven2_trainer::loop
