#include <gtest/gtest.h>

#include "raven2_trainer/core/pedals.h"
#include "support/mode_driver.h"

// Tests pure simulation, the return to the robot, emergency stops, the camera, view and tools: doc/modes.md.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::apart;
using raven2_trainer::testing::ModeDriver;

class Modes : public ::testing::Test {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    d = std::make_unique<ModeDriver>();
    ASSERT_TRUE(d->begin());
  }

  /** Moves the model 15 mm away from the robot in pure simulation. The pedal is up at the end. */
  void simulate() {
    ASSERT_EQ(d->ask(RequestKind::kBeginSimulation), PlanningAnswer::kAccepted);
    ASSERT_EQ(d->mode(), Mode::kSimulationHeld);
    d->stroke(600, 1.0);
    ASSERT_EQ(d->mode(), Mode::kSimulating);
    d->rest(true, 200);
    d->rest(false, 100);
    ASSERT_EQ(d->mode(), Mode::kSimulationHeld);
    ASSERT_GT(d->rig.error(Arm::kGold), 8e-3);
    ASSERT_GT(d->rig.error(Arm::kGreen), 5e-3);
  }

  std::unique_ptr<ModeDriver> d;
};

TEST_F(Modes, InPureSimulationTheRobotKnowsNothing) {
  const Vec3 gold = d->robotTip(Arm::kGold), green = d->robotTip(Arm::kGreen);
  d->watch = [this] {
    ASSERT_EQ(d->rig.last_relay.command.pedal, 0);
    ASSERT_EQ(d->rig.last_relay.command.dp_I[0], Vec3{});
    ASSERT_EQ(d->rig.force().force_B[0], Vec3{});
    ASSERT_EQ(d->rig.model().linked, 0);
  };
  simulate();
  EXPECT_LT(apart(d->robotTip(Arm::kGold), gold), 1e-6);
  EXPECT_LT(apart(d->robotTip(Arm::kGreen), green), 1e-6);
  const Vec3 held = d->modelTip();
  d->rest(false, 500);
  EXPECT_LT(apart(d->modelTip(), held), 0.1e-3) << "with the pedal up the model holds";
  EXPECT_GE(d->rig.model().session_tick, 500) << "the session began";
}

TEST_F(Modes, AClutchGoesOnFromWhereTheModelStands) {
  simulate();
  const Vec3 held = d->modelTip();
  d->rest(true, 100);
  EXPECT_LT(apart(d->modelTip(), held), 0.2e-3);
  d->stroke(400, 1.0);
  EXPECT_GT(apart(d->modelTip(), held), 5e-3);
}

TEST_F(Modes, TheModelGlidesBackAndOnlyThenThePedalCounts) {
  simulate();
  const double away = d->rig.error(Arm::kGold);
  Vec3 before = d->modelTip();
  double fastest = 0.0;
  d->watch = [&] {
    fastest = std::max(fastest, apart(d->modelTip(), before));
    before = d->modelTip();
    ASSERT_EQ(d->rig.last_relay.command.dp_I[0], Vec3{});
    ASSERT_EQ(d->rig.force().force_B[0], Vec3{});
  };
  ASSERT_EQ(d->ask(RequestKind::kEndSimulation), PlanningAnswer::kAccepted);
  ASSERT_EQ(d->mode(), Mode::kReturning);
  int ticks = 0;
  for (; d->mode() == Mode::kReturning && ticks < 5000; ++ticks) {
    d->rest(true, 1);  // the pedal stays down
    if (d->mode() == Mode::kReturning) {
      ASSERT_EQ(d->rig.model().pedal, 0);
      ASSERT_EQ(d->rig.last_relay.command.pedal, 0);
    }
  }
  EXPECT_EQ(d->mode(), Mode::kTeleoperating) << "the press counts once the return has ended";
  EXPECT_EQ(d->rig.model().linked, 1);
  EXPECT_LT(d->rig.error(Arm::kGold), 0.1e-3);
  EXPECT_LT(d->rig.error(Arm::kGreen), 0.1e-3);
  EXPECT_GT(ticks, 100);
  EXPECT_LT(fastest, 0.5e-3);
  EXPECT_GT(fastest, away / ticks) << "the model must have moved";
  d->rest(true, 300);
  EXPECT_LT(d->rig.error(Arm::kGold), 0.5e-3);
}

TEST_F(Modes, TheJawsComeBackAsModelAndRobotHadThem) {
  const double opening = kinematics::jawOpening(d->rig.model().arms[0].q_d);
  ASSERT_EQ(d->ask(RequestKind::kBeginSimulation), PlanningAnswer::kAccepted);
  d->stroke(300, 1.0, 0.02);
  ASSERT_LT(kinematics::jawOpening(d->rig.model().arms[0].q_d), opening - 0.3);
  d->rest(false, 50);
  ASSERT_EQ(d->ask(RequestKind::kEndSimulation), PlanningAnswer::kAccepted);
  ASSERT_TRUE(d->waitFor(Mode::kPedalUp));
  EXPECT_NEAR(kinematics::jawOpening(d->rig.model().arms[0].q_d), opening, 1e-9);
  d->rest(true, 100);
  // The jaws' opening at home is 0.8 mrad beyond ITP's limit.
  EXPECT_NEAR(kinematics::jawOpening(d->rig.model().arms[0].q_d), opening, 1e-3);
}

TEST_F(Modes, WithoutARobotSimulationEndsWhereItIs) {
  d->rig.robot_connected = false;
  d->rig.link.disconnected();
  d->rest(false, 10);
  ASSERT_EQ(d->ask(RequestKind::kBeginSimulation), PlanningAnswer::kAccepted);
  d->stroke(400, 1.0);
  d->rest(false, 200);
  const Vec3 held = d->modelTip();
  ASSERT_EQ(d->ask(RequestKind::kEndSimulation), PlanningAnswer::kAccepted);
  ASSERT_TRUE(d->waitFor(Mode::kPedalUp, 100));
  EXPECT_LT(apart(d->modelTip(), held), 0.2e-3);
}

TEST_F(Modes, AModelThatGoesOnAloneGlidesBackToo) {
  for (const bool is_asked : {true, false}) {
    SCOPED_TRACE(is_asked ? "disengaged with the pedal down" : "the robot was not heard for a while");
    d->stroke(200, 1.0);
    ASSERT_EQ(d->rig.model().linked, 1);
    if (is_asked) {
      ASSERT_EQ(d->ask(RequestKind::kDisengage, true), PlanningAnswer::kNone);
    } else {
      d->rig.robot_connected = false;
      d->rig.link.disconnected();
    }
    d->stroke(600, 1.0);
    d->rest(true, 100);
    EXPECT_EQ(d->rig.model().linked, 0);
    if (!is_asked) {
      d->rig.robot_connected = true;
      d->rig.connect();
      d->rest(true, 50);
    }
    ASSERT_GT(d->rig.error(Arm::kGold), 8e-3);
    Vec3 before = d->modelTip();
    double fastest = 0.0;
    d->watch = [&] {
      fastest = std::max(fastest, apart(d->modelTip(), before));
      before = d->modelTip();
    };
    d->rest(false, 5);
    EXPECT_EQ(d->mode(), Mode::kReturning);
    ASSERT_TRUE(d->waitFor(Mode::kPedalUp));
    d->watch = nullptr;
    EXPECT_LT(fastest, 0.5e-3) << "the model does not jump";
    EXPECT_LT(d->rig.error(Arm::kGold), 0.1e-3);
    d->ask(RequestKind::kEngage);
    d->stroke(200, -1.0);
    d->rest(true, 300);
    EXPECT_EQ(d->rig.model().linked, 1);
    EXPECT_LT(d->rig.error(Arm::kGold), 0.5e-3);
    d->rest(false, 60);
  }
}

TEST_F(Modes, NothingBeginsWithThePedalDown) {
  d->rest(true, 50);
  for (const RequestKind kind : {RequestKind::kBeginSimulation, RequestKind::kBeginTrial, RequestKind::kEndSimulation,
                                 RequestKind::kRepeatTrial, RequestKind::kToolChange, RequestKind::kClearStop}) {
    EXPECT_EQ(d->ask(kind, true), PlanningAnswer::kNotNow) << kRequestKindNames[static_cast<std::size_t>(kind)];
    EXPECT_EQ(d->mode(), Mode::kTeleoperating);
  }
}

TEST_F(Modes, ARobotThatMovedMeanwhileIsFound) {
  simulate();
  ASSERT_EQ(d->ask(RequestKind::kEndSimulation), PlanningAnswer::kAccepted);
  d->rest(false, 20);
  // WHEN its state reports a position 8 mm away from now on
  RobotState elsewhere = d->rig.robot();
  elsewhere.arms[0].q[kInsertion] += 0.008;
  d->rig.robot_connected = false;
  std::array<std::uint8_t, wire::kMaxFrame> frame;
  Vec3 before = d->modelTip();
  double fastest = 0.0;
  for (int i = 0; i < 4000 && d->mode() == Mode::kReturning; ++i) {
    ++elsewhere.cycle;
    const std::int64_t now_ns = elsewhere.time_ns = d->rig.model().time_ns + kTickNanoseconds;
    d->rig.link.receive(frame.data(), wire::encodeState(1, elsewhere, frame.data()), now_ns);
    d->rest(false, 1);
    fastest = std::max(fastest, apart(d->modelTip(), before));
    before = d->modelTip();
  }
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  EXPECT_NEAR(d->rig.model().arms[0].q[kInsertion], elsewhere.arms[0].q[kInsertion], 1e-3);
  EXPECT_LT(fastest, 0.5e-3);
}

TEST_F(Modes, AStopIsForEverythingAndClearedWithThePedalUp) {
  d->stroke(100, 1.0);
  EXPECT_EQ(d->ask(RequestKind::kEmergencyStop, true), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kStopped);
  EXPECT_EQ(d->rig.last_relay.command.pedal, 0) << "in the same tick";
  EXPECT_EQ(d->rig.last_relay.command.dp_I[0], Vec3{});
  const Vec3 stopped = d->robotTip();
  d->stroke(300, 1.0);
  EXPECT_EQ(d->mode(), Mode::kStopped);
  EXPECT_LT(apart(d->robotTip(), stopped), 0.5e-3);
  EXPECT_EQ(d->ask(RequestKind::kClearStop, true), PlanningAnswer::kNotNow);
  d->rest(false, 5);
  EXPECT_EQ(d->mode(), Mode::kStopped) << "releasing the pedal does not clear the stop";
  EXPECT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  EXPECT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kNotNow) << "there is no stop to clear";
  d->rest(true, 100);
  EXPECT_EQ(d->mode(), Mode::kTeleoperating);
  EXPECT_LT(d->rig.error(Arm::kGold), 0.5e-3);
}

TEST_F(Modes, TheStopOfARobotThatIsGoneCanBeCleared) {
  RobotState robot = d->rig.robot();
  robot.runlevel = RunLevel::kEStop;
  d->rig.hear(&robot);
  d->rest(false, 1);
  ASSERT_EQ(d->mode(), Mode::kStopped);
  EXPECT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kNotNow) << "the robot is there, and in E-STOP";
  d->rig.link.disconnected();
  d->rest(false, 5);
  EXPECT_EQ(d->mode(), Mode::kStopped) << "without a request it stays stopped";
  EXPECT_EQ(d->ask(RequestKind::kClearStop, true), PlanningAnswer::kNotNow) << "the pedal is down";
  d->rest(false, 2);
  EXPECT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  d->rest(true, 10);
  EXPECT_EQ(d->mode(), Mode::kTeleoperating) << "the model moves alone";
}

TEST_F(Modes, AStopIsNotClearedWhileTheModelCannotBeStepped) {
  TrainerConfig config = ModeDriver::configuration();
  config.model.gains[kShoulder].kp = std::nan("");
  d = std::make_unique<ModeDriver>(config);
  d->begin();
  ASSERT_TRUE(d->waitFor(Mode::kStopped, 100));
  d->ask(RequestKind::kEmergencyStop);
  EXPECT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kNotNow);
  EXPECT_EQ(d->mode(), Mode::kStopped);
}

TEST_F(Modes, AStopAwayFromTheRobotLeadsBackBeforeThePedalCounts) {
  simulate();
  EXPECT_EQ(d->ask(RequestKind::kEmergencyStop), PlanningAnswer::kAccepted);
  const Vec3 stopped = d->modelTip();
  d->rest(false, 300);
  EXPECT_LT(apart(d->modelTip(), stopped), 0.2e-3);
  EXPECT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kReturning);
  EXPECT_TRUE(d->waitFor(Mode::kPedalUp));
  d->rest(false, 2);
  EXPECT_LT(d->rig.error(Arm::kGold), 0.1e-3);
}

TEST_F(Modes, LostTimeLeavesASimulationASimulation) {
  simulate();
  d->rest(true, 50);
  ASSERT_EQ(d->mode(), Mode::kSimulating);
  d->rig.physics.timeSlip();
  d->rest(true, 100);
  EXPECT_EQ(d->mode(), Mode::kSimulationHeld) << "the simulation is held until a new pedal-down";
  d->rest(false, 5);
  d->rest(true, 5);
  EXPECT_EQ(d->mode(), Mode::kSimulating);
}

TEST_F(Modes, TheCamerasPedalMovesTheCameraAndNothingElse) {
  d->rest(true, 100);
  const Vec3 gold = d->robotTip();
  const CameraState before = d->rig.model().camera;
  EXPECT_EQ(d->ask(RequestKind::kSetCameraPedal, true, 0, 1), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kCameraMoving);
  EXPECT_EQ(d->rig.model().pedals, bit(Pedal::kCamera));
  EXPECT_EQ(d->rig.last_relay.command.pedal, 0);
  d->rest(true, 200);
  d->stroke(400, 1.0);
  const CameraState moved = d->rig.model().camera;
  EXPECT_GT(apart(moved.eye_W, before.eye_W), 5e-3);
  EXPECT_EQ(moved.target_W, before.target_W);
  EXPECT_LT(apart(d->robotTip(), gold), 0.5e-3);
  EXPECT_LT(apart(d->modelTip(), gold), 0.5e-3);
  // WHEN the camera's pedal goes up again while the arms' pedal is still down
  EXPECT_EQ(d->ask(RequestKind::kSetCameraPedal, true, 0, 0), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kTeleoperating) << "the arms' pedal counts as pressed again in the same tick";
  EXPECT_EQ(d->rig.model().linked, 1);
  EXPECT_EQ(d->rig.model().pedals, 0U);
  EXPECT_LT(d->rig.error(Arm::kGold), 0.5e-3);
  d->stroke(200, 1.0);
  EXPECT_EQ(d->rig.model().camera.eye_W, moved.eye_W);
  EXPECT_GT(apart(d->modelTip(), gold), 1e-3);
}

TEST_F(Modes, TheCamerasPedalWorksWithTheOtherUpAndGoesBackToWhatThereWas) {
  d->ask(RequestKind::kSetCameraPedal, false, 0, 1);
  MasterCommand command;
  command.dp_I = {Vec3{0.0, 20e-6, 0.0}, Vec3{0.0, 20e-6, 0.0}};
  const Vec3 eye = d->rig.model().camera.eye_W;
  for (int i = 0; i < 200; ++i)
    d->tick(command);
  EXPECT_GT(apart(d->rig.model().camera.eye_W, eye), 5e-3);
  d->ask(RequestKind::kSetCameraPedal, false, 0, 0);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  simulate();
  const Vec3 held = d->modelTip();
  d->ask(RequestKind::kSetCameraPedal, false, 0, 1);
  d->rest(false, 300);
  EXPECT_LT(apart(d->modelTip(), held), 0.2e-3) << "away from the robot the model holds its position";
  d->ask(RequestKind::kSetCameraPedal, false, 0, 0);
  EXPECT_EQ(d->mode(), Mode::kSimulationHeld);
}

TEST_F(Modes, ViewAndToolsAreCounted) {
  EXPECT_EQ(d->rig.model().view, 0);
  d->ask(RequestKind::kSetView, false, 0, 1);
  EXPECT_EQ(d->rig.model().view, 1);
  d->ask(RequestKind::kSetView, false, 0, 0);
  EXPECT_EQ(d->rig.model().view, 0);
  EXPECT_EQ(d->ask(RequestKind::kToolChange), PlanningAnswer::kAccepted);
  d->rest(false, 1);
  EXPECT_EQ(d->rig.model().faults.signals.tool_changes, 1U);
  d->ask(RequestKind::kToolChange);
  d->rest(false, 1);
  EXPECT_EQ(d->rig.model().faults.signals.tool_changes, 2U);
}

TEST_F(Modes, WhatIsNotServedIsRefused) {
  for (const RequestKind kind :
       {RequestKind::kBeginReplay, RequestKind::kEndReplay, RequestKind::kEndSimulation, RequestKind::kEndTrial,
        RequestKind::kDiscardTrial, RequestKind::kRepeatTrial, RequestKind::kClearStop}) {
    EXPECT_EQ(d->ask(kind), PlanningAnswer::kNotNow) << kRequestKindNames[static_cast<std::size_t>(kind)];
    EXPECT_EQ(d->mode(), Mode::kPedalUp);
  }
}

TEST_F(Modes, APressAfterAShownPathWaitsUntilTheModelIsBack) {
  d->ask(RequestKind::kPlan);
  d->answerPlan();
  d->rest(false, 600);
  ASSERT_EQ(d->mode(), Mode::kTracking);
  ASSERT_GT(d->rig.error(Arm::kGold), 3e-3);
  Vec3 before = d->modelTip();
  d->watch = [&] {
    ASSERT_LT(apart(d->modelTip(), before), 0.5e-3);
    before = d->modelTip();
  };
  d->rest(true, 1);
  EXPECT_EQ(d->mode(), Mode::kReturning);
  EXPECT_TRUE(d->waitFor(Mode::kTeleoperating, 3000, true));
  EXPECT_LT(d->rig.error(Arm::kGold), 0.5e-3);
  EXPECT_EQ(d->rig.model().planning.status, PlanningStatus::kReady) << "the surgeon may still follow the plan by hand";
}

}  // namespace
}  // namespace raven2_trainer::loop
