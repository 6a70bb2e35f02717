#include "loop/servo_manager.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "support/servo_client.h"

// Tests CRTK clients at the physics loop: states, who has the pedal, and the effect of their commands (doc/crtk.md).

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::apart;
using raven2_trainer::testing::beside;
using raven2_trainer::testing::ModeDriver;
using raven2_trainer::testing::Rig;
using raven2_trainer::testing::ServoClient;

double turnBetween(const Quat& a, const Quat& b) {
  return toEigen(a).angularDistance(toEigen(b));
}

// [m] At a pedal-down the set point becomes the arm's position, which lags behind the commanded one.
constexpr double kRebased = 2e-3;

// Dry friction holds the Raven's tool joints off their targets. Only the integral of their control law removes that: kp
// 0.05 Nm/rad over ki 0.05 Nm/(rad s) (raven2.md 3.6) are a time constant of a second.
constexpr int kSettle = 5000;                     // [ticks]
constexpr double kRobotOff = 0.5e-3;              // [m]
constexpr double kRobotTurn = 0.2 * kPi / 180.0;  // [rad]

class ServoManagerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { raven2_trainer::testing::useOde(); }

  /** Runs the model without a robot. */
  void alone(const std::function<void(TrainerConfig*)>& change = [](TrainerConfig*) {}) {
    TrainerConfig config = ModeDriver::configuration();
    change(&config);
    rig = std::make_unique<Rig>(config);
    rig->robot_connected = false;
    c = std::make_unique<ServoClient>(rig.get());
    c->rest(5);
    ASSERT_EQ(state(), OperatingState::kDisabled);
  }

  /** Runs the model with the virtual Raven, homed. */
  void together(const std::function<void(TrainerConfig*)>& change = [](TrainerConfig*) {}) {
    TrainerConfig config = ModeDriver::configuration();
    change(&config);
    rig = std::make_unique<Rig>(config);
    c = std::make_unique<ServoClient>(rig.get());
    ASSERT_TRUE(rig->home());
    c->rest(200);
    ASSERT_EQ(state(), OperatingState::kDisabled);
  }

  void request(RequestKind kind, std::uint8_t enabled = 0) {
    Request order;
    order.kind = kind;
    order.id = 1000;
    order.enabled = enabled;
    ASSERT_TRUE(rig->shared->requests.tryPush(order));
  }

  OperatingState state() const { return c->state().state; }
  Mode mode() const { return rig->model().mode; }
  RigidPose setpoint(Arm arm = Arm::kGold) const { return c->arm(arm).setpoint_B; }
  Vec3 tip() const { return setpoint().p; }

  std::unique_ptr<Rig> rig;
  std::unique_ptr<ServoClient> c;
};

// ---- states ------------------------------------------------------------------------------------------------------

TEST_F(ServoManagerTest, TheModelAloneIsHomedAndEnabledByAClient) {
  alone();
  EXPECT_EQ(c->state().is_homed, 1);
  EXPECT_EQ(c->ask(StateCommand::kPause), ServoRefusal::kInvalid);
  EXPECT_EQ(c->last.in, OperatingState::kDisabled);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNone);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(c->state().holds_pedal, 1);
  c->rest(3);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNone) << "a second enable is accepted";
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kInvalid);
  EXPECT_EQ(c->ask(StateCommand::kPause), ServoRefusal::kNone);
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(c->state().holds_pedal, 0);
  c->rest(2);
  EXPECT_EQ(rig->model().pedal, 0);
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  c->rest(3);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(c->ask(StateCommand::kDisable), ServoRefusal::kNone);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  c->rest(2);
  EXPECT_EQ(rig->model().pedal, 0);
  EXPECT_EQ(c->ask(StateCommand::kHome), ServoRefusal::kNone);
  EXPECT_EQ(c->ask(StateCommand::kUnhome), ServoRefusal::kNotOffered);
  const ServoState s = c->state();
  EXPECT_EQ(s.received, 9U);
  EXPECT_EQ(s.refused, 3U);
  EXPECT_EQ(s.applied, 6U);
  EXPECT_EQ(s.tick, rig->model().tick);
}

TEST_F(ServoManagerTest, PauseAndResumeInOneTickIsANewPedalDown) {
  alone();
  ASSERT_TRUE(c->enable());
  c->send(StateCommand::kPause);
  c->send(StateCommand::kResume);
  c->rest(1);
  EXPECT_EQ(rig->model().pedal, 0);
  c->rest(2);
  EXPECT_EQ(rig->model().pedal, kClientsPedal);
  c->rest(20);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
}

TEST_F(ServoManagerTest, WithoutBeingEnabledNothingMoves) {
  alone();
  const Vec3 before = tip();
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, beside(setpoint(), {0.005, 0.0, 0.0})),
            ServoRefusal::kNotEnabled);
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.03, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(300);
  EXPECT_GT(apart(tip(), before), 1e-3);
  EXPECT_EQ(c->ask(StateCommand::kPause), ServoRefusal::kNone);
  EXPECT_FALSE(c->isBusy());
  c->rest(2);
  const Vec3 stopped = tip();
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, beside(setpoint(), {0.005, 0.0, 0.0})),
            ServoRefusal::kNotEnabled);
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.03, 0.0, 0.0})), ServoRefusal::kNotEnabled);
  c->rest(300);
  EXPECT_LT(apart(tip(), stopped), 1e-9);
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  c->rest(500);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_LT(apart(tip(), stopped), kRebased) << "the old command is forgotten";
}

TEST_F(ServoManagerTest, FreeLetsGoAsAPauseDoes) {
  alone();
  ServoCommand let_go;
  let_go.kind = ServoKind::kFree;
  EXPECT_EQ(c->ask(let_go), ServoRefusal::kInvalid);
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(let_go), ServoRefusal::kNone);
  EXPECT_EQ(state(), OperatingState::kPaused);
}

TEST_F(ServoManagerTest, AClientThatFallsSilentLosesThePedal) {
  alone([](TrainerConfig* config) { config->crtk.release_after = 0.5; });
  ASSERT_TRUE(c->enable());
  c->rest(300);
  ServoCommand hold;
  EXPECT_EQ(c->ask(hold), ServoRefusal::kNone);
  c->rest(490);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  c->rest(15);
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(rig->model().pedal, 0);
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  c->rest(3);
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGreen, beside(setpoint(Arm::kGreen), {0.02, 0.0, 0.0})),
            ServoRefusal::kNone);
  c->rest(800);  // 0.94 s
  EXPECT_EQ(state(), OperatingState::kEnabled) << "a client with a move under way is not silent";
}

TEST_F(ServoManagerTest, AClientThatKeepsAskingInVainKeepsTheArms) {
  alone([](TrainerConfig* config) { config->crtk.release_after = 0.5; });
  ASSERT_TRUE(c->enable());
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {2.0, 0.0, 0.0})),
              ServoRefusal::kUnreachable);
    c->rest(200);
    rig->shared->servo_unread.add();  // a message that could not be read
    c->rest(400);
    EXPECT_EQ(state(), OperatingState::kEnabled) << i;
  }
  c->rest(150);
  EXPECT_EQ(state(), OperatingState::kPaused);
}

TEST_F(ServoManagerTest, AStopByRequestDisablesAndOnlyTheRequestThatClearsItEndsIt) {
  alone();
  ASSERT_TRUE(c->enable());
  request(RequestKind::kEmergencyStop);
  c->rest(2);
  EXPECT_EQ(mode(), Mode::kStopped);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, setpoint()), ServoRefusal::kNotEnabled);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kOperatorStop);
  c->rest(50);
  EXPECT_EQ(mode(), Mode::kStopped);
  EXPECT_EQ(rig->model().pedal, 0);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  request(RequestKind::kClearStop);
  c->rest(2);
  EXPECT_EQ(mode(), Mode::kPedalUp);
  EXPECT_EQ(state(), OperatingState::kDisabled) << "clearing the stop does not enable";
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNone);
  c->rest(5);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(state(), OperatingState::kEnabled);
}

TEST_F(ServoManagerTest, OtherModesAreEndedFirst) {
  alone();
  request(RequestKind::kBeginTrial);
  c->rest(2);
  ASSERT_EQ(mode(), Mode::kTrialHeld);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kMode);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  c->rest(5);
  EXPECT_EQ(mode(), Mode::kTrialHeld);
  EXPECT_EQ(rig->model().pedal, 0);
}

TEST_F(ServoManagerTest, AnotherModeBeginsBeforeAClientHasThePedalOrNotAtAll) {
  alone();
  c->send(StateCommand::kEnable);
  request(RequestKind::kBeginSimulation);  // in the same tick, before the pedal
  for (int i = 0; i < 20; ++i) {
    c->rest(1);
    ASSERT_EQ(mode(), Mode::kSimulationHeld);
    ASSERT_EQ(rig->model().pedal, 0);
  }
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kMode);
  request(RequestKind::kEndSimulation);
  c->rest(200);
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  c->rest(5);
  ASSERT_EQ(mode(), Mode::kTeleoperating);
  request(RequestKind::kBeginSimulation);
  c->rest(5);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
}

TEST_F(ServoManagerTest, TheCamerasPedalKeepsTheArmsStill) {
  alone();
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.03, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(100);
  request(RequestKind::kSetCameraPedal, static_cast<std::uint8_t>(CameraPedal::kPressed));
  c->rest(3);
  ASSERT_EQ(mode(), Mode::kCameraMoving);
  const Vec3 before = tip(), camera = rig->model().camera.eye_W;
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, setpoint()), ServoRefusal::kMode);
  c->rest(100);
  EXPECT_EQ(rig->model().camera.eye_W, camera) << "a client does not move the camera";
  request(RequestKind::kSetCameraPedal, static_cast<std::uint8_t>(CameraPedal::kReleased));
  c->rest(300);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_LT(apart(tip(), before), kRebased) << "the old command is forgotten";
}

TEST_F(ServoManagerTest, LostTimePauses) {
  alone();
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.03, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(100);
  rig->physics.timeSlip();
  c->rest(1);
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(mode(), Mode::kPaused);
  const Vec3 before = tip();
  c->rest(100);
  EXPECT_EQ(mode(), Mode::kPaused);
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  c->rest(300);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_LT(apart(tip(), before), kRebased);
}

// ---- the surgeon's console ---------------------------------------------------------------------------------------

TEST_F(ServoManagerTest, TheConsoleTakesThePedalAtOnceAndAClientNeverTakesItsOwn) {
  alone();
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.02, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(100);
  const std::uint64_t overruled = rig->counts().master_overruled;
  EXPECT_GT(overruled, 90U) << "the console's pedal-ups did not count";
  c->rest(1, /*console_pedal=*/true);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(c->state().holds_pedal, 0);
  const Vec3 taken = tip();
  c->rest(200, true);
  EXPECT_LT(apart(tip(), taken), 1e-9) << "the client's move has ended";
  EXPECT_EQ(mode(), Mode::kTeleoperating) << "teleoperation goes on without a break";
  c->send(ServoKind::kServoPose, Arm::kGold, setpoint());
  c->rest(1, true);
  EXPECT_EQ(c->last.reason, ServoRefusal::kConsole);
  c->send(StateCommand::kPause);
  c->rest(1, true);
  EXPECT_EQ(c->last.reason, ServoRefusal::kConsole);
  EXPECT_EQ(c->last.kind, ServoKind::kState);
  rig->tick(true, {0.0, 0.0, -40e-6});
  EXPECT_GT(apart(tip(), taken), 30e-6) << "the surgeon moves";
  c->rest(5);
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(mode(), Mode::kPedalUp);
  EXPECT_EQ(rig->counts().master_overruled, overruled) << "the surgeon's own release counts";
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
}

TEST_F(ServoManagerTest, WhatAClientMovesIsNoMotionOfTheHands) {
  alone();
  ASSERT_TRUE(c->enable());
  const Vec3 hand = rig->model().master_I[0], from = tip();
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, beside(setpoint(), {0.01, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(200);
  EXPECT_GT(apart(tip(), from), 9e-3);
  EXPECT_EQ(rig->model().master_I[0], hand);
  EXPECT_EQ(rig->model().pedal, kClientsPedal);
  rig->tick(true, {0.0, 0.0, -40e-6});
  EXPECT_EQ(rig->model().pedal, kSurgeonsPedal) << "the surgeon takes the pedal without a break";
  EXPECT_NEAR(rig->model().master_I[0][2], hand[2] - 40e-6, 1e-12);
  c->rest(5);
  EXPECT_EQ(rig->model().pedal, 0);
}

TEST_F(ServoManagerTest, AConsoleThatFallsSilentWithItsPedalDownPauses) {
  alone();
  c->rest(100, true);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(c->state().holds_pedal, 0);
  std::int64_t now = rig->model().time_ns;
  for (int i = 0; i < 300; ++i)  // the loop alone: the console is silent
    rig->physics.tick(now += kTickNanoseconds);
  EXPECT_EQ(state(), OperatingState::kPaused);
}

TEST_F(ServoManagerTest, AClientsPedalNeedsNoConsole) {
  alone();
  ASSERT_TRUE(c->enable());
  std::int64_t now = rig->model().time_ns;
  for (int i = 0; i < 1000; ++i)
    rig->physics.tick(now += kTickNanoseconds);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
}

// ---- motion of the model -----------------------------------------------------------------------------------------

TEST_F(ServoManagerTest, ServoJpReachesItsJoints) {
  alone();
  ASSERT_TRUE(c->enable());
  PerArm<ServoJoints> goal{c->arm(Arm::kGold).setpoint_q, c->arm(Arm::kGreen).setpoint_q};
  for (const Arm arm : kArms) {
    ServoJoints& q = at(goal, arm);
    q = {q[0] + 0.02, q[1] - 0.03, q[2] - 0.004, q[3] + 0.2, q[4] - 0.1, q[5] + 0.12};
    EXPECT_EQ(c->ask(ServoKind::kServoJoints, arm, q), ServoRefusal::kNone);
  }
  c->rest(500);
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kServoJointCount; ++j)
      EXPECT_NEAR(c->arm(arm).setpoint_q[j], at(goal, arm)[j], 1e-4) << name(arm) << " " << j;
  }
  EXPECT_FALSE(c->isBusy());
  c->rest(700);
  for (const Arm arm : kArms)  // the model reaches its set points
    EXPECT_LT(apart(at(rig->model().arms, arm).p_BT, setpoint(arm).p), 1.5e-3);
}

TEST_F(ServoManagerTest, ServoCpLeadsTheSetPointAlongALine) {
  alone();
  ASSERT_TRUE(c->enable());
  const RigidPose from = setpoint(), to = beside(from, {0.008, -0.01, 0.006}, 0.15);
  const Vec3 green = setpoint(Arm::kGreen).p;
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, to), ServoRefusal::kNone);
  EXPECT_LT(apart(c->arm(Arm::kGold).goal_B.p, to.p), 1e-12);
  const Vector3 way = (toEigen(to.p) - toEigen(from.p)).normalized();
  double fastest = 0.0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 before = tip();
    c->rest(1);
    fastest = std::max(fastest, apart(tip(), before));
    const Vector3 gone = toEigen(tip()) - toEigen(from.p);
    ASSERT_LT((gone - gone.dot(way) * way).norm(), 2e-6);
  }
  EXPECT_LT(apart(tip(), to.p), 1e-6) << "whole micrometres add up";
  EXPECT_LT(turnBetween(setpoint().q, to.q), 1e-6);
  EXPECT_LT(fastest, 0.1e-3 + 2e-6);
  EXPECT_GT(fastest, 0.09e-3);
  EXPECT_LT(apart(setpoint(Arm::kGreen).p, green), 1e-12) << "the other arm holds";
}

TEST_F(ServoManagerTest, MovesAreBusyUntilTheyAreThere) {
  alone();
  ASSERT_TRUE(c->enable());
  const RigidPose from = setpoint(), first = beside(from, {0.0, 0.01, 0.0}), second = beside(from, {0.01, 0.0, 0.0});
  c->send(ServoKind::kMovePose, Arm::kGold, first);
  c->send(ServoKind::kMovePose, Arm::kGold, second);
  c->sendJaw(ServoKind::kMoveJaw, Arm::kGreen, 1.4);
  c->rest(4);
  EXPECT_EQ(c->refusals, 0U);
  EXPECT_EQ(c->arm(Arm::kGold).is_busy, 1);
  EXPECT_EQ(c->arm(Arm::kGreen).is_busy, 1);
  double nearest = 1.0;
  int ticks = 0;
  for (; c->isBusy() && ticks < 10000; ++ticks) {
    c->rest(1);
    nearest = std::min(nearest, apart(tip(), first.p));
  }
  EXPECT_LT(nearest, 2e-6) << "the tip passes through the first goal";
  EXPECT_LT(apart(tip(), second.p), 1e-6);
  EXPECT_NEAR(c->arm(Arm::kGreen).setpoint_jaw, 1.4, 0.5e-3 + 1e-9) << "whole milliradians";
  EXPECT_GT(ticks, 1100) << "15/8 of 10 and 14.1 mm at 40 mm/s";
}

TEST_F(ServoManagerTest, MillimetresForMetresMoveNothing) {
  alone();
  ASSERT_TRUE(c->enable());
  const Vec3 before = tip();
  RigidPose millimetres = setpoint();
  for (double& x : millimetres.p)
    x *= 1e3;
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, millimetres), ServoRefusal::kTooFar);
  EXPECT_EQ(c->last.limit, 0.02);
  EXPECT_GT(c->last.value, 10.0);
  EXPECT_EQ(c->last.in, OperatingState::kEnabled);
  c->rest(100);
  EXPECT_LT(apart(tip(), before), 1e-12);
}

TEST_F(ServoManagerTest, NoTickOfAClientsExceedsWhatAMasterMaySend) {
  alone([](TrainerConfig* config) {
    config->network.itp.max_increment_um = 30;
    config->network.itp.max_rotation = 0.0005;
  });
  rig->record = [this] {
    const auto& ring = rig->shared->command_records;
    for (std::uint64_t i = ring.head(); i < ring.tail(); ++i) {
      for (const Arm arm : kArms) {
        for (const double d : at(ring.at(i).command.dp_I, arm))
          ASSERT_LE(std::abs(d), 30.5e-6);
        ASSERT_LE(turnBetween(at(ring.at(i).command.dq_I, arm), kIdentityQuat), 0.00050001);
      }
    }
  };
  ASSERT_TRUE(c->enable());
  const RigidPose to = beside(setpoint(), {0.015, 0.0, 0.0}, 0.2);
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, to), ServoRefusal::kNone);
  c->rest(800);
  EXPECT_LT(apart(tip(), to.p), 1e-6);
  rig->record = nullptr;
}

TEST_F(ServoManagerTest, AFaultOfTheMastersStreamIsMadeGoodAtTheRateOfAServo) {
  alone([](TrainerConfig* config) {
    Fault& fault = raven2_trainer::testing::onlyFaultOf(config, "sudden_jump");
    fault.host = FaultHost::kMaster;
    fault.site = FaultSite::kNetworkLayer;
    fault.kind = FaultKind::kAdd;
    fault.variable = FaultVariable::kIncrement;
    fault.channel = 0;
    fault.value = 100.0;
    fault.first_tick = 200;
    fault.duration_ticks = 20;
    fault.count = 1;
    config->hazard = "sudden_jump";
  });
  ASSERT_TRUE(c->enable());
  const RigidPose to = beside(setpoint(), {0.005, 0.0, 0.0});
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, to), ServoRefusal::kNone);
  double off = 0.0;
  for (int i = 0; i < 600; ++i) {
    c->rest(1);
    if (i > 120) off = std::max(off, apart(tip(), to.p));
  }
  EXPECT_GT(off, 50e-6) << "the fault must show";
  EXPECT_LT(apart(tip(), to.p), 1e-6);
}

// ---- model and robot ---------------------------------------------------------------------------------------------

TEST_F(ServoManagerTest, WhileTheRobotHomesItIsBusyAndMovesNothing) {
  rig = std::make_unique<Rig>(ModeDriver::configuration());
  c = std::make_unique<ServoClient>(rig.get());
  for (int i = 0; i < 3000 && rig->robot().runlevel != RunLevel::kInit; ++i)
    c->rest(1);
  c->rest(2);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  EXPECT_EQ(c->state().is_homed, 0);
  EXPECT_TRUE(c->isBusy());
  EXPECT_EQ(c->ask(StateCommand::kHome), ServoRefusal::kNone);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNone);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, setpoint()), ServoRefusal::kNotHomed);
  for (int i = 0; i < 20000 && mode() != Mode::kTeleoperating; ++i)
    c->rest(1);
  c->rest(100);
  EXPECT_EQ(c->state().is_homed, 1);
  EXPECT_FALSE(c->isBusy());
  EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalDown);
  EXPECT_EQ(state(), OperatingState::kEnabled);
}

TEST_F(ServoManagerTest, TheRobotIsWhereItIsAskedToBeOnceItsToolJointsSettled) {
  together();
  ASSERT_TRUE(c->enable());
  for (const bool in_joints : {false, true}) {
    for (const Arm arm : kArms) {
      const ServoArmState now = c->arm(arm);
      const double side = arm == Arm::kGold ? 1.0 : -1.0;
      ServoJoints q = now.setpoint_q;
      q = {q[0] + 0.02, q[1] - 0.02, q[2] - 0.004, q[3] + 0.15, q[4] + 0.1, q[5] - 0.1};
      const RigidPose to = beside(now.setpoint_B, {0.006, side * 0.008, -0.006}, side * 0.15);
      const ServoRefusal reason =
          in_joints ? c->ask(ServoKind::kServoJoints, arm, q) : c->ask(ServoKind::kServoPose, arm, to);
      ASSERT_EQ(reason, ServoRefusal::kNone);
    }
    c->rest(kSettle);
    for (const Arm arm : kArms) {
      const Pose X_BT = kinematics::forward(rig->config.arms.geometry, arm, at(rig->robot().arms, arm).q);
      const double off = apart(toArray(X_BT.p), setpoint(arm).p);
      const double turned = turnBetween(toArray(Quaternion(X_BT.R)), setpoint(arm).q);
      EXPECT_LT(off, kRobotOff) << name(arm) << (in_joints ? " servo_jp" : " servo_cp");
      EXPECT_LT(turned, kRobotTurn) << name(arm) << (in_joints ? " servo_jp" : " servo_cp");
      RecordProperty(std::string(name(arm)) + (in_joints ? "_jp_um" : "_cp_um"), static_cast<int>(off * 1e6));
      RecordProperty(std::string(name(arm)) + (in_joints ? "_jp_urad" : "_cp_urad"), static_cast<int>(turned * 1e6));
    }
  }
  EXPECT_EQ(rig->model().linked, 1);
}

TEST_F(ServoManagerTest, WhatFrictionKeepsARestingRobotFromIsAskedForInAddition) {
  constexpr std::size_t kElbow = 1;
  const auto worst_elbow = [&](double trim_time, int settle) {
    together([&](TrainerConfig* config) { config->crtk.trim_time = trim_time; });
    EXPECT_TRUE(c->enable());
    PerArm<double> asked{};
    for (const Arm arm : kArms) {
      ServoJoints q = c->arm(arm).setpoint_q;
      q[kElbow] += 0.03;
      at(asked, arm) = q[kElbow];
      EXPECT_EQ(c->ask(ServoKind::kServoJoints, arm, q), ServoRefusal::kNone);
    }
    c->rest(settle);
    double worst = 0.0;
    for (const Arm arm : kArms) {
      EXPECT_NEAR(c->arm(arm).setpoint_q[kElbow], at(asked, arm), 2e-4) << "the published set point has no trim";
      worst = std::max(worst, std::abs(control::servoJoints(at(rig->robot().arms, arm).q)[kElbow] - at(asked, arm)));
    }
    return worst;
  };
  EXPECT_GT(worst_elbow(0.0, 1500), 2e-3) << "dry friction over kp: up to 3.5 mrad";
  EXPECT_LT(worst_elbow(ModeDriver::configuration().crtk.trim_time, 3000), 0.7e-3)
      << "control::ServoTrim::kEnough, and noise";
}

/** Increments into a limit become motions along it, and model and robot may go different ways. */
TEST_F(ServoManagerTest, AnArmThatRestsAtAJointsLimitIsNotAskedToGoBeyondIt) {
  for (const double trim_time : {0.0, ModeDriver::configuration().crtk.trim_time}) {
    together([&](TrainerConfig* config) {
      config->crtk.trim_time = trim_time;
      config->crtk.move_turn_rate = config->crtk.max_turn_rate;
    });
    ASSERT_TRUE(c->enable());
    for (const Arm arm : kArms) {
      ServoJoints q = c->arm(arm).setpoint_q;
      q[kElbow] = rig->config.arms.geometry.q_min[kElbow];
      ASSERT_EQ(c->ask(ServoKind::kMoveJoints, arm, q), ServoRefusal::kNone);
    }
    c->rest(2500);
    ASSERT_FALSE(c->isBusy());
    PerArm<double> pushed{};
    for (int tick = 0; tick < 1000; ++tick) {
      c->rest(1);
      for (const Arm arm : kArms) {
        const bool is_at_limit =
            at(rig->model().arms, arm).ik_status == static_cast<std::uint32_t>(kinematics::IkStatus::kClamped);
        if (is_at_limit) at(pushed, arm) += toEigen(at(rig->last_relay.command.dp_I, arm)).norm();
      }
    }
    for (const Arm arm : kArms) {
      EXPECT_LT(at(pushed, arm), 1e-5) << name(arm) << ", trim " << trim_time;
      const ServoJoints robot = control::servoJoints(at(rig->robot().arms, arm).q), wanted = c->arm(arm).setpoint_q;
      EXPECT_NEAR(robot[kElbow], wanted[kElbow], control::ServoTrim::kLimit[kElbow]) << name(arm);
    }
  }
}

TEST_F(ServoManagerTest, WhatIsAskedForBeforeTheRobotFollowsIsDoneOnceItDoes) {
  together();
  const RigidPose to = beside(setpoint(), {0.004, 0.0, 0.0});
  c->send(StateCommand::kEnable);
  c->send(ServoKind::kMovePose, Arm::kGold, to);
  c->rest(600);
  EXPECT_EQ(c->refusals, 0U);
  EXPECT_LT(apart(tip(), to.p), 1e-6);
}

TEST_F(ServoManagerTest, ARobotThatGoesAwayPausesAndResumingDoesNotLeap) {
  together();
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.02, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(100);
  rig->robot_connected = false;
  rig->link.disconnected();
  c->rest(3);
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_FALSE(c->isBusy());
  rig->robot_connected = true;
  rig->connect();
  c->rest(2000);
  EXPECT_EQ(state(), OperatingState::kPaused);
  const Vec3 before = tip();
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  c->rest(300);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(rig->model().linked, 1);
  EXPECT_LT(apart(tip(), before), 0.5e-3);
}

TEST_F(ServoManagerTest, ARobotThatDoesNotHearTheClientsPedalPausesItAndResumingEngagesIt) {
  together();
  rig->robot_hears = false;
  c->rest(1200);
  c->send(StateCommand::kEnable);
  c->rest(100);
  EXPECT_EQ(state(), OperatingState::kPaused);
  rig->robot_hears = true;
  c->rest(500);
  EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalUp) << "the robot must not go pedal-down by itself";
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(rig->model().linked, 1);
}

TEST_F(ServoManagerTest, ARobotThatComesWhileTheModelMovesAlonePausesAndIsJoinedByResuming) {
  together();
  rig->robot_connected = false;
  rig->link.disconnected();
  c->rest(10);
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->state().alone, 1);
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.02, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(300);
  rig->robot_connected = true;
  rig->connect();
  for (int i = 0; i < 100 && state() == OperatingState::kEnabled; ++i)
    c->rest(1);
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(rig->model().linked, 0);
  EXPECT_FALSE(c->isBusy());
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  const RigidPose there = setpoint();
  for (int i = 0; i < 3000 && mode() != Mode::kTeleoperating; ++i) {
    const ServoRefusal reason = c->ask(ServoKind::kServoPose, Arm::kGold, there);  // 20 mm from the robot
    if (mode() == Mode::kReturning) {
      EXPECT_NE(reason, ServoRefusal::kNone);
    }
  }
  c->rest(300);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(rig->model().linked, 1);
  EXPECT_EQ(c->state().alone, 0);
}

TEST_F(ServoManagerTest, TheCamerasPedalKeepsARobotStillAndTheClientEnabled) {
  together();
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.02, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(200);
  request(RequestKind::kSetCameraPedal, static_cast<std::uint8_t>(CameraPedal::kPressed));
  c->rest(100);
  ASSERT_EQ(mode(), Mode::kCameraMoving);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  const Vec3 before = tip();
  request(RequestKind::kSetCameraPedal, static_cast<std::uint8_t>(CameraPedal::kReleased));
  c->rest(300);
  EXPECT_EQ(mode(), Mode::kTeleoperating);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(rig->model().linked, 1);
  EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalDown);
  EXPECT_LT(apart(tip(), before), kRebased) << "the old command is forgotten";
  const RigidPose to = beside(setpoint(), {0.003, 0.0, 0.0});
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, to), ServoRefusal::kNone);
  c->rest(200);
  EXPECT_LT(apart(tip(), to.p), 1e-6);
}

TEST_F(ServoManagerTest, DisengagingPauses) {
  together();
  ASSERT_TRUE(c->enable());
  request(RequestKind::kDisengage);
  c->rest(3);
  EXPECT_EQ(state(), OperatingState::kPaused);
}

TEST_F(ServoManagerTest, AnEStopOfTheRobotIsAFaultThatIsEndedAtTheRobot) {
  together();
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, beside(setpoint(), {0.02, 0.0, 0.0})), ServoRefusal::kNone);
  c->rest(50);
  // The robot's frames, with its own state replaced.
  rig->robot_connected = false;
  RobotState said = rig->robot();
  std::array<std::uint8_t, wire::kMaxFrame> frame{};
  std::uint32_t number = 1000000;
  const auto says = [&](RunLevel level, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      said.runlevel = level;
      ++said.cycle;
      said.time_ns = rig->model().time_ns + kTickNanoseconds;
      rig->link.receive(frame.data(), wire::encodeState(++number, said, frame.data()), said.time_ns);
      c->rest(1);
    }
  };
  says(RunLevel::kEStop, 2);
  EXPECT_EQ(state(), OperatingState::kFault);
  EXPECT_EQ(mode(), Mode::kStopped);
  EXPECT_EQ(rig->last_relay.command.pedal, 0);
  EXPECT_FALSE(c->isBusy());
  c->send(StateCommand::kEnable);
  says(RunLevel::kEStop, 1);
  EXPECT_EQ(c->last.reason, ServoRefusal::kRobotStop);
  c->send(StateCommand::kHome);
  says(RunLevel::kEStop, 1);
  EXPECT_EQ(c->last.id, c->last_id);
  EXPECT_EQ(c->last.reason, ServoRefusal::kRobotStop);
  EXPECT_EQ(state(), OperatingState::kFault);
  says(RunLevel::kPedalUp, 50);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  EXPECT_EQ(rig->model().pedal, 0);
}

// ---- forces ------------------------------------------------------------------------------------------------------

ServoCommand wrenchOf(Arm arm, const Vec3& force, WrenchFrame frame = WrenchFrame::kTip) {
  ServoCommand command;
  command.kind = ServoKind::kServoWrench;
  command.arm = arm;
  command.force = force;
  command.frame = frame;
  return command;
}

TEST_F(ServoManagerTest, AForceMovesTheModelAloneItsWayUntilSomethingElseIsAskedFor) {
  for (const Arm arm : kArms) {
    alone([](TrainerConfig* config) { config->crtk.twist_timeout = 5.0; });
    ASSERT_TRUE(c->enable());
    c->rest(300);
    const Arm other = arm == Arm::kGold ? Arm::kGreen : Arm::kGold;
    const Vec3 start = at(rig->model().arms, arm).p_BT, stood = at(rig->model().arms, other).p_BT;
    ASSERT_EQ(c->ask(wrenchOf(arm, {0.0, 0.0, 15.0})), ServoRefusal::kNone);
    c->rest(300);
    const Vec3 pushed = at(rig->model().arms, arm).p_BT;
    EXPECT_GT(pushed[2] - start[2], 1e-3) << name(arm);
    EXPECT_LT(apart(at(rig->model().arms, other).p_BT, stood), 1e-4);
    EXPECT_NEAR(apart(c->arm(arm).setpoint_B.p, pushed), 0.0, 1e-3) << "the set point follows the arm";
    ServoCommand hold;
    hold.arm = arm;
    ASSERT_EQ(c->ask(hold), ServoRefusal::kNone);
    c->rest(500);
    const Vec3 held = at(rig->model().arms, arm).p_BT;
    c->rest(300);
    EXPECT_LT(apart(at(rig->model().arms, arm).p_BT, held), 2e-4) << "the controllers hold the arm again";
    EXPECT_EQ(c->ask(ServoKind::kMovePose, arm, beside(c->arm(arm).setpoint_B, {0.0, 0.0, -0.005})),
              ServoRefusal::kNone);
    const Vec3 goal = c->arm(arm).goal_B.p;
    c->rest(1500);
    EXPECT_LT(apart(at(rig->model().arms, arm).p_BT, goal), 1e-3);
  }
}

TEST_F(ServoManagerTest, AMoveIsOverWithTheForceThatCameBehindIt) {
  for (const Arm arm : kArms) {
    alone([](TrainerConfig* config) { config->crtk.twist_timeout = 0.1; });
    ASSERT_TRUE(c->enable());
    c->rest(300);
    ASSERT_EQ(c->ask(ServoKind::kMovePose, arm, beside(c->arm(arm).setpoint_B, {0.0, 0.0, -0.02})),
              ServoRefusal::kNone);
    c->rest(100);
    ASSERT_EQ(c->arm(arm).is_busy, 1);
    ASSERT_EQ(c->ask(wrenchOf(arm, {0.0, 0.0, 1.0})), ServoRefusal::kNone);
    c->rest(2);
    EXPECT_EQ(c->arm(arm).is_busy, 0) << name(arm);
    c->rest(600);  // the force has ended
    const Vec3 stood = c->arm(arm).setpoint_B.p;
    c->rest(1000);
    EXPECT_LT(apart(c->arm(arm).setpoint_B.p, stood), 1e-4) << name(arm) << ": the move does not go on";
  }
}

TEST_F(ServoManagerTest, TorquesOnJointsMoveEachTheirWayAndEndWithTheirTime) {
  alone([](TrainerConfig* config) { config->crtk.twist_timeout = 0.2; });
  ASSERT_TRUE(c->enable());
  c->rest(200);
  for (const double sign : {1.0, -1.0}) {
    const double before = rig->model().arms[1].q[kShoulder];
    ASSERT_EQ(c->ask(ServoKind::kServoForces, Arm::kGreen, ServoJoints{sign * 1.5, 0, 0, 0, 0, 0}),
              ServoRefusal::kNone);
    c->rest(150);
    EXPECT_GT(sign * (rig->model().arms[1].q[kShoulder] - before), 1e-3);
    c->rest(200);
    EXPECT_GE(c->arm(Arm::kGreen).run_out, 1U);
    c->rest(500);
    const double stood = rig->model().arms[1].q[kShoulder];
    c->rest(200);
    EXPECT_NEAR(rig->model().arms[1].q[kShoulder], stood, 1e-4);
  }
  EXPECT_EQ(c->arm(Arm::kGold).run_out, 0U);
}

TEST_F(ServoManagerTest, AForceOnTheJawsLeavesTheArmWhereItIs) {
  alone();
  ASSERT_TRUE(c->enable());
  c->rest(300);
  const ModelState before = rig->model();
  ServoCommand open;
  open.kind = ServoKind::kServoJawForce;
  open.jaw = 0.03;
  ASSERT_EQ(c->ask(open), ServoRefusal::kNone);
  c->rest(200);
  const ModelState after = rig->model();
  EXPECT_GT(kinematics::jawOpening(after.arms[0].q) - kinematics::jawOpening(before.arms[0].q), 0.02);
  EXPECT_LT(apart(after.arms[0].p_BT, before.arms[0].p_BT), 1e-3);
}

TEST_F(ServoManagerTest, GravityIsCompensatedBesideAForceUnlessAClientLeavesTheArmItsWeight) {
  alone();
  ASSERT_TRUE(c->enable());
  c->rest(300);
  ServoCommand weight;
  weight.kind = ServoKind::kGravity;
  weight.number = 0.0;
  const ServoJoints asked{0.1, -0.05, 1.0, 0.0, 0.01, 0.0};
  for (const Arm arm : kArms) {
    ASSERT_EQ(c->ask(ServoKind::kServoForces, arm, asked), ServoRefusal::kNone);
    c->rest(2);
    const JointArray held = at(rig->model().arms, arm).tau;
    EXPECT_GT(std::abs(held[kElbow] - asked[kElbow]), 0.1) << "[Nm] the arm's weight is compensated";
    weight.arm = arm;
    ASSERT_EQ(c->ask(weight), ServoRefusal::kNone);
    c->rest(2);
    const JointArray bare = at(rig->model().arms, arm).tau;
    for (std::size_t j = 0; j < 5; ++j)
      EXPECT_NEAR(bare[j], asked[j], 1e-9) << name(arm) << " " << kJointNames[j];
  }
}

TEST_F(ServoManagerTest, AForceThatIsAskedForWithThePedalDownActsOnceTheModelTakesIt) {
  alone();
  ASSERT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNone);
  const Vec3 start = rig->model().arms[1].p_BT;
  ASSERT_EQ(c->ask(wrenchOf(Arm::kGreen, {0.0, 0.0, 15.0})), ServoRefusal::kNone) << "one command is enough";
  c->rest(400);
  EXPECT_GT(rig->model().arms[1].p_BT[2] - start[2], 1e-3);
}

TEST_F(ServoManagerTest, AForceEndsWhenARobotComes) {
  together();
  rig->robot_connected = false;
  rig->link.disconnected();
  c->rest(10);
  ASSERT_TRUE(c->enable());
  ASSERT_EQ(c->ask(ServoKind::kServoForces, Arm::kGold, ServoJoints{0.5, 0, 0, 0, 0, 0}), ServoRefusal::kNone);
  c->rest(20);
  const std::uint64_t made = rig->counts().efforts_made;
  rig->robot_connected = true;
  rig->connect();
  for (int i = 0; i < 100 && rig->counts().efforts_made == made; ++i)
    c->rest(1);
  EXPECT_EQ(rig->counts().efforts_made, made + 1);
  c->rest(200);
  EXPECT_EQ(state(), OperatingState::kPaused);
}

TEST_F(ServoManagerTest, ForcesAreRefusedWithARobotAndBeyondTheControllers) {
  together();
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(wrenchOf(Arm::kGold, {0.0, 0.0, 1.0})), ServoRefusal::kHasRobot);
  EXPECT_EQ(c->ask(ServoKind::kServoForces, Arm::kGreen, ServoJoints{}), ServoRefusal::kHasRobot);
  EXPECT_EQ(c->ask(StateCommand::kDisable), ServoRefusal::kNone);
  EXPECT_EQ(c->ask(wrenchOf(Arm::kGold, {0.0, 0.0, 1.0})), ServoRefusal::kHasRobot) << "whatever the state";
  alone();
  EXPECT_EQ(c->ask(wrenchOf(Arm::kGold, {0.0, 0.0, 1.0})), ServoRefusal::kNotEnabled);
  ASSERT_TRUE(c->enable());
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(c->ask(wrenchOf(Arm::kGold, {0.0, 0.0, sign * 1e4})), ServoRefusal::kTooStrong);
    EXPECT_EQ(c->ask(ServoKind::kServoForces, Arm::kGreen, ServoJoints{0, 0, 0, 0, 0, sign * 1e3}),
              ServoRefusal::kTooStrong);
    EXPECT_EQ(c->last.joint, 5);
  }
  EXPECT_EQ(c->ask(wrenchOf(Arm::kGold, {0.0, std::nan(""), 0.0})), ServoRefusal::kNotFinite);
  ServoCommand tool;
  tool.kind = ServoKind::kTool;
  EXPECT_EQ(c->ask(tool), ServoRefusal::kNotOffered);
}

// ---- set points while the model moves without the robot -----------------------------------------------------------

TEST_F(ServoManagerTest, ASetPointOfTheRobotsIsNoneOfAPlanThatTheModelTracks) {
  together();
  Request order;
  order.kind = RequestKind::kPlan;
  order.id = 1001;
  const PerArm<RigidPose> before{setpoint(Arm::kGold), setpoint(Arm::kGreen)};
  ASSERT_TRUE(rig->shared->requests.tryPush(order));
  c->rest(2);
  PlanRequest asked;
  ASSERT_TRUE(rig->shared->plan_requests.tryPop(&asked));
  PlanResult plan;
  plan.id = asked.id;
  plan.status = PlanStatus::kSuccess;
  plan.arm = asked.arm;
  plan.waypoint_count = 2;
  plan.waypoints[0] = plan.waypoints[1] = asked.start;
  plan.waypoints[1][kShoulder] += 0.4;
  plan.arrival[1] = 2.0;
  ASSERT_TRUE(rig->shared->plan_results.tryPush(plan));
  double model_went = 0.0, told_jump = 0.0, told_went = 0.0;
  Vec3 last = setpoint(plan.arm).p;
  const Vec3 stood = at(rig->model().arms, plan.arm).p_BT;
  for (int i = 0; i < 4000; ++i) {
    c->rest(1);
    const Vec3 now = setpoint(plan.arm).p;
    told_jump = std::max(told_jump, apart(now, last));
    told_went = std::max(told_went, apart(now, at(before, plan.arm).p));
    model_went = std::max(model_went, apart(at(rig->model().arms, plan.arm).p_BT, stood));
    last = now;
    if (i > 1000 && mode() == Mode::kPedalUp) break;
  }
  EXPECT_GT(model_went, 0.02) << "the model must move far enough";
  EXPECT_LT(told_jump, 0.5e-3) << "[m] in a tick";
  EXPECT_LT(told_went, 1e-3);
}

// ---- the robot's own dialect -------------------------------------------------------------------------------------

void speakRaven(TrainerConfig* config) {
  config->crtk.dialect = CrtkDialect::kRaven;
}

TEST_F(ServoManagerTest, InTheRavensDialectAHomedRobotIsPausedAndResumes) {
  TrainerConfig config = ModeDriver::configuration();
  speakRaven(&config);
  rig = std::make_unique<Rig>(config);
  c = std::make_unique<ServoClient>(rig.get());
  for (int i = 0, stopped = 0; i < 5000 && rig->robot().runlevel != RunLevel::kInit; ++i) {
    c->rest(1);
    const bool is_stopped = rig->robot().connected != 0 && rig->robot().runlevel == RunLevel::kEStop;
    if (is_stopped && ++stopped > 1) ASSERT_EQ(state(), OperatingState::kDisabled) << "not started";
  }
  ASSERT_EQ(rig->robot().runlevel, RunLevel::kInit);
  c->rest(5);
  EXPECT_EQ(state(), OperatingState::kEnabled) << "as the robot's branch: ENABLED and busy while it homes";
  EXPECT_TRUE(c->isBusy());
  EXPECT_EQ(c->state().is_homed, 0);
  EXPECT_EQ(c->state().holds_pedal, 0);
  EXPECT_EQ(c->ask(ServoKind::kServoPose, Arm::kGold, setpoint()), ServoRefusal::kNotHomed);
  ASSERT_TRUE(rig->home());
  c->rest(200);
  EXPECT_EQ(state(), OperatingState::kPaused);
  EXPECT_EQ(c->ask(StateCommand::kResume), ServoRefusal::kNone);
  c->rest(300);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_EQ(rig->model().linked, 1);
  EXPECT_EQ(c->ask(StateCommand::kDisable), ServoRefusal::kNone);
  c->rest(300);
  EXPECT_EQ(state(), OperatingState::kDisabled) << "as the client asked";
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNone);
  EXPECT_EQ(c->ask(StateCommand::kPause), ServoRefusal::kNone);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNone) << "enable acts as resume";
  EXPECT_EQ(state(), OperatingState::kEnabled);
}

TEST_F(ServoManagerTest, InTheRavensDialectADisableIsOverWithTheNextEnable) {
  TrainerConfig config = ModeDriver::configuration();
  speakRaven(&config);
  rig = std::make_unique<Rig>(config);
  rig->robot_connected = false;
  c = std::make_unique<ServoClient>(rig.get());
  c->rest(5);
  ASSERT_EQ(c->ask(StateCommand::kDisable), ServoRefusal::kNone);
  ASSERT_TRUE(c->enable());
  ASSERT_EQ(c->ask(StateCommand::kUnhome), ServoRefusal::kNone);
  c->rest(20);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  ASSERT_EQ(c->ask(StateCommand::kHome), ServoRefusal::kNone);
  c->rest(2);
  EXPECT_EQ(state(), OperatingState::kPaused) << "the earlier disable no longer holds";
}

TEST_F(ServoManagerTest, InTheRavensDialectUnhomeIsRefusedWhileTheConsoleHasThePedal) {
  TrainerConfig config = ModeDriver::configuration();
  speakRaven(&config);
  rig = std::make_unique<Rig>(config);
  rig->robot_connected = false;
  c = std::make_unique<ServoClient>(rig.get());
  c->rest(5);
  c->rest(5, /*console_pedal=*/true);
  c->send(StateCommand::kUnhome);
  c->rest(2, true);
  EXPECT_EQ(c->last.reason, ServoRefusal::kConsole);
  EXPECT_EQ(c->state().is_homed, 1);
  EXPECT_EQ(rig->model().pedal, kSurgeonsPedal) << "the surgeon keeps the arms";
  c->rest(5);
  EXPECT_EQ(c->ask(StateCommand::kUnhome), ServoRefusal::kNone) << "once the console's pedal is up";
}

TEST_F(ServoManagerTest, InTheRavensDialectUnhomeDisablesUntilHome) {
  TrainerConfig config = ModeDriver::configuration();
  speakRaven(&config);
  rig = std::make_unique<Rig>(config);
  rig->robot_connected = false;
  c = std::make_unique<ServoClient>(rig.get());
  c->rest(5);
  EXPECT_EQ(state(), OperatingState::kPaused) << "a model without a robot counts as homed";
  ASSERT_TRUE(c->enable());
  EXPECT_EQ(c->ask(StateCommand::kUnhome), ServoRefusal::kNone);
  c->rest(20);
  EXPECT_EQ(state(), OperatingState::kDisabled);
  EXPECT_EQ(c->state().is_homed, 0);
  EXPECT_EQ(rig->model().pedal, 0);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kNotHomed);
  EXPECT_EQ(c->ask(StateCommand::kHome), ServoRefusal::kNone);
  c->rest(2);
  EXPECT_EQ(c->state().is_homed, 1);
  EXPECT_EQ(state(), OperatingState::kPaused);
  ASSERT_TRUE(c->enable());
}

/** crtk-cpp's crtk_test_state, tests 4 to 6: the state says so while the robot homes on. */
TEST_F(ServoManagerTest, InTheRavensDialectWhatDisablesAHomingRobotIsShown) {
  for (const StateCommand command : {StateCommand::kPause, StateCommand::kDisable, StateCommand::kUnhome}) {
    SCOPED_TRACE(kStateCommandNames[static_cast<std::size_t>(command)]);
    TrainerConfig config = ModeDriver::configuration();
    speakRaven(&config);
    rig = std::make_unique<Rig>(config);
    c = std::make_unique<ServoClient>(rig.get());
    for (int i = 0; i < 5000 && rig->robot().runlevel != RunLevel::kInit; ++i)
      c->rest(1);
    c->rest(5);
    ASSERT_EQ(state(), OperatingState::kEnabled);
    EXPECT_EQ(c->ask(command), ServoRefusal::kNone);
    c->rest(5);
    EXPECT_EQ(state(), OperatingState::kDisabled);
    EXPECT_EQ(c->state().is_homed, 0);
    EXPECT_TRUE(c->isBusy()) << "it homes on";
    ASSERT_TRUE(rig->home());
    c->rest(200);
    EXPECT_EQ(state(), OperatingState::kDisabled) << "as the client asked";
    EXPECT_EQ(c->state().is_homed, command == StateCommand::kUnhome ? 0 : 1);
  }
}

/** crtk-cpp's crtk_test_state, test 8: a person presses the emergency stop, releases it and starts the robot again. */
TEST_F(ServoManagerTest, InTheRavensDialectARobotThatHomesAgainIsHomed) {
  TrainerConfig config = ModeDriver::configuration();
  speakRaven(&config);
  rig = std::make_unique<Rig>(config);
  c = std::make_unique<ServoClient>(rig.get());
  ASSERT_TRUE(rig->home());
  c->rest(200);
  EXPECT_EQ(c->ask(StateCommand::kUnhome), ServoRefusal::kNone);
  c->rest(20);
  ASSERT_EQ(c->state().is_homed, 0);
  RobotState said = rig->robot();
  const auto says = [&](RunLevel level, bool is_homed) {
    said.runlevel = level;
    said.homed = is_homed ? 1 : 0;
    for (int i = 0; i < 5; ++i) {
      rig->hear(&said);
      c->rest(1);
    }
  };
  says(RunLevel::kEStop, false);
  EXPECT_EQ(c->state().is_homed, 0);
  says(RunLevel::kInit, false);
  EXPECT_EQ(state(), OperatingState::kEnabled);
  EXPECT_TRUE(c->isBusy());
  says(RunLevel::kPedalUp, true);
  EXPECT_EQ(c->state().is_homed, 1);
  EXPECT_EQ(state(), OperatingState::kPaused);
}

/** A client reads the joint, its limit, and whether it rotates. */
TEST_F(ServoManagerTest, AForceBeyondTheControllerOfAnyJointIsRefusedOnBothSides) {
  alone();
  ASSERT_TRUE(c->enable());
  const auto gains = ModeDriver::configuration().model.gains;
  for (const Arm arm : kArms) {
    for (const double sign : {1.0, -1.0}) {
      for (std::size_t j = 0; j <= kServoJointCount; ++j) {
        const bool is_jaw = j == kServoJointCount;
        const double limit = gains[is_jaw ? kGrasp1 : j].limit;
        ServoCommand push;
        push.arm = arm;
        push.kind = is_jaw ? ServoKind::kServoJawForce : ServoKind::kServoForces;
        (is_jaw ? push.jaw : push.joints.at(j)) = sign * 1.01 * limit;
        EXPECT_EQ(c->ask(push), ServoRefusal::kTooStrong) << name(arm) << " " << j << " " << sign;
        EXPECT_EQ(c->last.joint, j);
        EXPECT_EQ(c->last.is_turn, j == kInsertion ? 0 : 1) << j;
        EXPECT_EQ(c->last.value, sign * 1.01 * limit) << j;
        EXPECT_EQ(c->last.limit, limit) << j;
      }
    }
  }
}

TEST_F(ServoManagerTest, AnArmThatWasLeftItsWeightIsHeldAgainOnceAClientAsksForIt) {
  alone();
  ASSERT_TRUE(c->enable());
  c->rest(300);
  const ServoJoints asked{0.1, -0.05, 1.0, 0.0, 0.01, 0.0};
  for (const Arm arm : kArms) {
    ASSERT_EQ(c->ask(ServoKind::kServoForces, arm, asked), ServoRefusal::kNone);
    for (const bool is_held : {false, true}) {
      ServoCommand weight;
      weight.kind = ServoKind::kGravity;
      weight.arm = arm;
      weight.number = is_held ? 1.0 : 0.0;
      ASSERT_EQ(c->ask(weight), ServoRefusal::kNone);
      c->rest(2);
      const double more = std::abs(at(rig->model().arms, arm).tau[kElbow] - asked[kElbow]);
      EXPECT_EQ(more > 0.1, is_held) << name(arm) << ": " << more
                                     << " Nm on the elbow in addition to what was asked for";
    }
  }
}

TEST_F(ServoManagerTest, AForceOfAClientThatIsGoneEnds) {
  for (const Arm arm : kArms) {
    alone([](TrainerConfig* config) { config->crtk.twist_timeout = 5.0; });
    ASSERT_TRUE(c->enable());
    c->rest(300);
    ASSERT_EQ(c->ask(wrenchOf(arm, {0.0, 0.0, 15.0})), ServoRefusal::kNone);
    c->rest(50);
    ServoCommand left;
    left.kind = ServoKind::kEndForces;
    left.arm = arm;
    ASSERT_EQ(c->ask(left), ServoRefusal::kNone);
    c->rest(500);
    const Vec3 held = at(rig->model().arms, arm).p_BT;
    c->rest(300);
    EXPECT_LT(apart(at(rig->model().arms, arm).p_BT, held), 2e-4) << name(arm);
  }
}

TEST_F(ServoManagerTest, AClientWhoseForceWasRefusedEndsNoTwistWhenItIsGone) {
  together();
  ASSERT_TRUE(c->enable());
  for (const Arm arm : kArms) {
    ASSERT_EQ(c->ask(wrenchOf(arm, {0.0, 0.0, 15.0})), ServoRefusal::kHasRobot);
    ServoCommand twist;
    twist.kind = ServoKind::kServoTwist;
    twist.arm = arm;
    twist.v_B = {0.0, 0.005, 0.0};
    ASSERT_EQ(c->ask(twist), ServoRefusal::kNone);
    ServoCommand left;
    left.kind = ServoKind::kEndForces;
    left.arm = arm;
    ASSERT_EQ(c->ask(left), ServoRefusal::kNone);
    c->rest(100);
    const Vec3 from = c->arm(arm).setpoint_B.p;
    c->rest(400);
    EXPECT_NEAR(apart(c->arm(arm).setpoint_B.p, from), 0.005 * 0.4, 5e-5) << name(arm);
  }
}

TEST_F(ServoManagerTest, AMoveUnderASmallLimitOfPacketsGoesOnWithoutStanding) {
  alone([](TrainerConfig* config) { config->network.itp.max_increment_um = 10; });
  ASSERT_TRUE(c->enable());
  const RigidPose from = setpoint(), to = beside(from, {0.012, 0.0, 0.0});
  ASSERT_EQ(c->ask(ServoKind::kMovePose, Arm::kGold, to), ServoRefusal::kNone);
  int still = 0;
  for (int i = 0; i < 6000 && c->isBusy(); ++i) {
    const Vec3 before = tip();
    c->rest(1);
    const double gone = apart(tip(), from.p);
    still += gone > 0.001 && gone < 0.011 && apart(tip(), before) < 0.5e-6 ? 1 : 0;
  }
  EXPECT_EQ(still, 0);
  EXPECT_LT(apart(tip(), to.p), 1.5e-6);
}

TEST_F(ServoManagerTest, AModelThatCannotBeSteppedIsAFault) {
  TrainerConfig config = ModeDriver::configuration();
  config.model.gains[kShoulder].kp = std::nan("");
  rig = std::make_unique<Rig>(config);
  rig->robot_connected = false;
  c = std::make_unique<ServoClient>(rig.get());
  c->rest(5);
  EXPECT_EQ(mode(), Mode::kStopped);
  EXPECT_EQ(state(), OperatingState::kFault);
  EXPECT_EQ(c->ask(StateCommand::kEnable), ServoRefusal::kMode);
}

}  // namespace
}  // namespace raven2_trainer::loop
