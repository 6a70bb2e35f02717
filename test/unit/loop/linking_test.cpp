#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/core/random.h"
#include "support/effort.h"
#include "support/rig.h"

// Tests how model and robot stay together: the rules are in the comment of PhysicsLoop.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::packagedConfig;
using raven2_trainer::testing::Rig;

class Linking : public ::testing::Test {
 protected:
  static TrainerConfig configuration() {
    TrainerConfig config = packagedConfig();
    config.hazard = "none";
    config.runtime.plan_at = -1.0;
    return config;
  }

  void SetUp() override {
    raven2_trainer::testing::useOde();
    rig = std::make_unique<Rig>(configuration());
    ASSERT_TRUE(rig->home());
  }

  /** A stroke of `ticks` with the pedal down: smooth, up to 0.05 mm a millisecond, whole micrometres. */
  void stroke(int ticks, double direction) {
    for (int i = 0; i < ticks; ++i) {
      const double speed = 25e-6 * (1.0 - std::cos(2.0 * kPi * i / ticks));
      rig->tick(true, {std::round(direction * speed * 1e6) * 1e-6, 0.0, 0.0});
    }
  }

  void rest(bool pedal, int ticks) {
    for (int i = 0; i < ticks; ++i)
      rig->tick(pedal);
  }

  std::unique_ptr<Rig> rig;
};

TEST_F(Linking, ClutchingLeavesNoOffset) {
  Random random(2);
  const auto clutches = static_cast<int>(raven2_trainer::testing::effort(30, 100));
  for (int clutch = 0; clutch < clutches; ++clutch) {
    stroke(100, clutch % 2 == 0 ? 1.0 : -1.0);
    rest(true, 20 + static_cast<int>(random.uniform(0, 20)));  // the pedal goes up while both still settle
    rest(false, 60);
    ASSERT_LT(rig->error(Arm::kGold), 0.5e-3) << "after clutch " << clutch;
  }
  rest(true, 500);
  EXPECT_LT(rig->error(Arm::kGold), 0.5e-3);
  EXPECT_LT(rig->error(Arm::kGreen), 0.5e-3);
}

TEST_F(Linking, ModelAndRobotStartFromOnePose) {
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating);
  EXPECT_EQ(rig->model().linked, 1);
  EXPECT_LT(rig->error(Arm::kGold), 0.1e-3);
  EXPECT_EQ(rig->model().session_tick, 0);
}

TEST_F(Linking, TheRobotEndsWhereTheIncrementsPointAndSoDoesTheModel) {
  rest(true, 100);
  const Vector3 start = toEigen(rig->model().arms[0].p_BT);
  stroke(400, 1.0);
  rest(true, 600);
  const Vector3 moved = toEigen(rig->model().arms[0].p_BT) - start;
  // ITP x is forward; the gold base's y points toward the surgeon. 400 ticks of mean 25 um.
  EXPECT_NEAR(moved.y(), -10.0e-3, 0.3e-3);
  EXPECT_LT(rig->error(Arm::kGold), 0.5e-3);
}

TEST_F(Linking, ARobotThatGoesAwayLeavesTheModelWorkingAndTheCueSilent) {
  rest(true, 100);
  rig->robot_connected = false;
  rig->link.disconnected();
  stroke(200, 1.0);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating);
  EXPECT_EQ(rig->model().linked, 0);
  EXPECT_EQ(rig->force().active, 0);
  EXPECT_EQ(rig->force().force_B[0], Vec3{});
}

TEST_F(Linking, AReturningRobotIsNotMovedNorFeltBeforeTheNextPedalDown) {
  rest(true, 100);
  rig->robot_connected = false;
  rig->link.disconnected();
  stroke(400, 1.0);  // the model moves 10 mm without the robot
  rig->robot_connected = true;
  rig->connect();
  for (int i = 0; i < 300; ++i) {
    rig->tick(true, {20e-6, 0.0, 0.0});
    ASSERT_EQ(rig->last_relay.command.pedal, 0);
    ASSERT_EQ(rig->force().force_B[0], Vec3{});
  }
  EXPECT_GT(rig->error(Arm::kGold), 5e-3) << "model and robot must be apart, or the test checks nothing";
  rest(false, 1000);
  EXPECT_LT(rig->error(Arm::kGold), 0.1e-3) << "pedal up: the model goes back to the robot";
  rest(true, 50);
  EXPECT_EQ(rig->model().linked, 1);
}

class DeafRobot : public Linking {
 protected:
  /** The robot hears nothing for `before` + `held` ticks, the pedal down in the last `held`; then it hears again. */
  void run(int before, int held, int after) {
    rest(true, 100);
    rest(false, 100);
    rig->robot_hears = false;
    rest(false, before);
    rest(true, held);
    EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalUp) << "the robot must not hear the press";
    rig->robot_hears = true;
    for (int i = 0; i < after; ++i) {
      rig->tick(true, {20e-6, 0.0, 0.0});
      ASSERT_EQ(rig->last_relay.command.pedal, 0) << i;
      ASSERT_EQ(rig->model().linked, 0) << i;
    }
  }
};

TEST_F(DeafRobot, IsNotEngagedByAPressThatItDidNotHear) {
  run(300, 2000, 500);
  rest(false, 200);
  rest(true, 100);
  EXPECT_EQ(rig->model().linked, 1) << "a new press engages the robot";
  EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalDown);
}

TEST_F(DeafRobot, IsNotEngagedByAPressOfTheLastMoment) {
  run(1100, 20, 500);
}

TEST_F(DeafRobot, ThatLetGoByItselfIsNotEngagedByAPedalThatStayedDown) {
  rest(true, 100);
  rig->robot_hears = false;
  for (int i = 0; i < 8000 && rig->robot().runlevel == RunLevel::kPedalDown; ++i)
    rig->tick(true);
  ASSERT_EQ(rig->robot().runlevel, RunLevel::kPedalUp) << "the robot takes the pedal as released";
  rig->robot_hears = true;
  rest(true, 500);
  EXPECT_EQ(rig->model().linked, 0);
  EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalUp);
}

// The robot stays in PEDAL_DN for 5 s without packets: it hears neither the release nor the press. Presses before and
// after the 1 s from which a robot counts as deaf; both arms, both directions.
TEST_F(DeafRobot, ThatStillHeldTheLastPressIsNotEngagedByTheNext) {
  for (const int released_at : {300, 1500}) {
    for (const double step : {20e-6, -20e-6}) {
      rig = std::make_unique<Rig>(configuration());
      ASSERT_TRUE(rig->home());
      rest(true, 100);
      rig->robot_hears = false;
      rest(true, released_at);
      rest(false, 200);
      rest(true, 1500);
      ASSERT_EQ(rig->robot().runlevel, RunLevel::kPedalDown) << "the robot must not hear the release";
      rig->robot_hears = true;
      for (int i = 0; i < 300; ++i) {
        rig->tick(true, {step, 0.0, 0.0});
        ASSERT_EQ(rig->last_relay.command.pedal, 0) << released_at << ' ' << i;
        ASSERT_EQ(rig->model().linked, 0) << released_at << ' ' << i;
      }
      rest(false, 1000);
      rest(true, 100);
      EXPECT_EQ(rig->model().linked, 1) << "a new press engages the robot";
      EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalDown);
    }
  }
}

TEST_F(DeafRobot, ThatHeardThePressGoesOnAfterAShortSilence) {
  rest(true, 100);
  rig->robot_hears = false;
  rest(true, 2000);
  rig->robot_hears = true;
  rest(true, 100);
  EXPECT_EQ(rig->model().linked, 1) << "it is still the same press";
}

TEST_F(DeafRobot, IsNoneWhoReportsNoSequence) {
  rig = std::make_unique<Rig>(configuration());
  rig->tells_sequence = false;
  ASSERT_TRUE(rig->home());
  rest(false, 1000);
  rest(true, 100);
  EXPECT_EQ(rig->model().linked, 1);
}

TEST_F(Linking, ARobotThatStartsAnewIsNotLinkedBeforeItIsHomed) {
  // GIVEN a robot that restarts unnoticed: the daemon never sees its E-STOP, and its first frame says INIT
  RobotState anew;
  anew.cycle = 1;
  anew.runlevel = RunLevel::kInit;
  anew.arms = rig->robot().arms;
  anew.arms[0].q[kShoulder] -= 0.1;
  rig->robot_connected = false;
  rig->link.disconnected();
  rest(false, 5);
  rig->connect();
  std::array<std::uint8_t, wire::kMaxFrame> frame;
  for (int i = 0; i < 200; ++i) {
    ++anew.cycle;
    rig->link.receive(frame.data(), wire::encodeState(1, anew, frame.data()), (1 << 30));
    rig->tick(true);
    ASSERT_EQ(rig->model().linked, 0);
    ASSERT_EQ(rig->force().force_B[0], Vec3{});
  }
}

TEST_F(Linking, DisengagedTheModelMovesAloneUntilEngagedAndPressedAgain) {
  Request request;
  request.kind = RequestKind::kDisengage;
  ASSERT_TRUE(rig->shared->requests.tryPush(request));
  rest(true, 50);
  const Vec3 robot_before = rig->robot().arms[0].p_BT;
  stroke(300, 1.0);
  EXPECT_LT((toEigen(rig->robot().arms[0].p_BT) - toEigen(robot_before)).norm(), 0.3e-3);
  EXPECT_GT(rig->error(Arm::kGold), 3e-3);
  EXPECT_EQ(rig->force().force_B[0], Vec3{}) << "model and robot are apart on purpose, which is no hazard";
}

TEST_F(Linking, ASilentMasterCountsAsPedalUp) {
  rest(true, 100);
  ASSERT_EQ(rig->model().mode, Mode::kTeleoperating);
  for (int i = 0; i < 250; ++i)
    rig->physics.tick((10000 + i) * kTickNanoseconds);
  EXPECT_EQ(rig->model().pedal, 0);
}

TEST_F(Linking, TheRelaysPacketsHaveNoGap) {
  stroke(300, 1.0);
  EXPECT_EQ(rig->robot().itp.rejectedTotal(), 0U);
  EXPECT_EQ(rig->robot().last_sequence, rig->last_relay.command.sequence);
}

TEST(LinkingAtStart, ThePedalDoesNothingBeforeTheRobotIsHomed) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = packagedConfig();
  config.hazard = "none";
  Rig rig(config);
  rig.tick(false);  // the robot's first frame
  for (int i = 0; i < 500; ++i)
    rig.tick(true, {10e-6, 0.0, 0.0});
  EXPECT_EQ(rig.model().mode, Mode::kWaiting);
  EXPECT_EQ(rig.model().session_tick, -1);
}

}  // namespace
}  // namespace raven2_trainer::loop
