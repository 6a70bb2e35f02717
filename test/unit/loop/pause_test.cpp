#include <gtest/gtest.h>

#include "support/rig.h"

// Tests how lost time affects the exercise: PhysicsLoop::timeSlip().

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::Rig;

class Pause : public ::testing::Test {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    TrainerConfig config = raven2_trainer::testing::packagedConfig();
    config.hazard = "none";
    config.runtime.plan_at = -1.0;
    rig = std::make_unique<Rig>(config);
    ASSERT_TRUE(rig->home());
  }

  void rest(bool pedal, int ticks, const Vec3& dp = {}) {
    for (int i = 0; i < ticks; ++i)
      rig->tick(pedal, dp);
  }

  void askForPlan() {
    Request request;
    request.kind = RequestKind::kPlan;
    request.id = 7;
    rig->shared->requests.tryPush(request);
  }

  std::unique_ptr<Rig> rig;
};

TEST_F(Pause, LostTimeHoldsTheModelStopsTheSessionsClockAndReleasesTheRobot) {
  rest(true, 200, {10e-6, 0.0, 0.0});
  ASSERT_EQ(rig->model().linked, 1);
  const ModelState before = rig->model();
  rig->physics.timeSlip();
  for (int i = 0; i < 500; ++i) {
    rig->tick(true, {20e-6, 0.0, 0.0});
    ASSERT_EQ(rig->model().mode, Mode::kPaused);
    ASSERT_EQ(rig->last_relay.command.pedal, 0);
    ASSERT_EQ(rig->model().session_tick, before.session_tick + 1)
        << "the session gets the tick that was due, and no more";
  }
  EXPECT_EQ(rig->model().tick, before.tick + 500) << "the simulated time goes on";
  EXPECT_LT((toEigen(rig->model().arms[0].p_BT) - toEigen(before.arms[0].p_BT)).norm(), 0.3e-3);
  EXPECT_EQ(rig->robot().runlevel, RunLevel::kPedalUp);
  EXPECT_EQ(rig->force().force_B[0], Vec3{});
}

/** A jump is the motion of one tick, which goes to the robot as one packet. */
TEST_F(Pause, WhatWaitsAfterAStallIsNeverOneJump) {
  rest(true, 200);
  ASSERT_EQ(rig->model().linked, 1);
  const double limit = rig->config.network.itp.max_increment_um * 1e-6;
  MasterCommand command;
  command.pedal = 1;
  command.dp_I[0] = {100e-6, -60e-6, 0.0};
  constexpr int kWaiting = 130;  // commands of a hand at 1 m/s; the physics was stopped for 130 ms
  for (int i = 0; i < kWaiting; ++i)
    rig->send(command);
  Vec3 sent{};
  int ticks = 0;
  for (; sent[0] < kWaiting * 100e-6 - 1e-9 && ticks < kWaiting; ++ticks) {
    rig->tick(true);
    const Vec3& dp = rig->last_relay.command.dp_I[0];
    ASSERT_LE(std::abs(dp[0]), limit + 1e-12);
    for (std::size_t axis = 0; axis < 3; ++axis)
      sent[axis] += dp[axis];
  }
  EXPECT_EQ(ticks, 7) << "20 commands of 100 um fill the 2 mm of one packet";
  EXPECT_NEAR(sent[1], -60e-6 * kWaiting, 1e-9) << "no increment is lost";
}

TEST_F(Pause, OnlyANewPedalDownGoesOnAndFromACommonPose) {
  rest(true, 200, {10e-6, 0.0, 0.0});
  rig->physics.timeSlip();
  rest(true, 100);
  rest(false, 100);
  EXPECT_EQ(rig->model().mode, Mode::kPaused);
  const Tick stopped = rig->model().session_tick;
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating);
  EXPECT_EQ(rig->model().linked, 1);
  EXPECT_LT(rig->error(Arm::kGold), 0.1e-3);
  rest(true, 50);
  EXPECT_EQ(rig->model().session_tick, stopped + 50) << "the session's clock continues where it stopped";
}

TEST_F(Pause, AForceEndsWithinFiftyMilliseconds) {
  // GIVEN a model 10 mm ahead of a robot that does not get its increments
  rest(true, 100);
  for (int i = 0; i < 400 && toEigen(rig->force().force_B[0]).norm() < 0.5; ++i) {
    rig->tick(true, {900e-6, 0.0, 0.0});  // faster than the robot can move
  }
  ASSERT_GT(toEigen(rig->force().force_B[0]).norm(), 0.4);
  rig->physics.timeSlip();
  rest(true, 50);
  EXPECT_EQ(rig->force().force_B[0], Vec3{});
}

TEST_F(Pause, AnotherThreadsLostTimePausesAtTheNextTick) {
  rest(true, 10);
  rig->physics.requestPause();
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating);
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kPaused);
}

/** Each is answered once. */
TEST_F(Pause, AnOperatorsPauseIsAnsweredAndRefusedWhereNothingWouldBePaused) {
  const auto pause = [this](std::uint32_t id, bool pedal) {
    EXPECT_TRUE(rig->shared->pause_requests.tryPush(id));
    rest(pedal, 1);
    const ModelState model = rig->model();
    RequestAnswer answer;
    EXPECT_TRUE(rig->shared->answers.tryPop(&answer));
    EXPECT_EQ(answer.id, id);
    EXPECT_EQ(answer.mode, model.mode);
    EXPECT_NE(model.planning.answered, id) << "resimulation does not know it";
    return answer.answer;
  };
  rest(false, 10);
  EXPECT_EQ(pause(1001, false), PlanningAnswer::kNotNow);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
  rest(true, 200);
  EXPECT_EQ(pause(1002, true), PlanningAnswer::kAccepted);
  EXPECT_EQ(rig->model().mode, Mode::kPaused);
  EXPECT_EQ(pause(1003, true), PlanningAnswer::kAccepted) << "it is paused";
  rest(false, 100);
  rest(true, 1);
  EXPECT_EQ(rig->model().mode, Mode::kTeleoperating);
  RequestAnswer none;
  EXPECT_FALSE(rig->shared->answers.tryPop(&none));
}

TEST_F(Pause, AWantedPlanIsForgottenAndRefusedLaterOn) {
  rest(true, 10);
  rest(false, 10);
  askForPlan();
  rest(false, 1);
  ASSERT_EQ(rig->model().mode, Mode::kPlanning);
  rig->physics.timeSlip();
  PlanResult result;
  result.id = 7;
  result.status = PlanStatus::kSuccess;
  rig->shared->plan_results.tryPush(result);
  rest(false, 1);
  EXPECT_EQ(rig->model().mode, Mode::kPaused);
  EXPECT_EQ(rig->shared->last_plan.load().status, PlanStatus::kCancelled);
  askForPlan();
  rest(false, 1);
  EXPECT_EQ(rig->model().mode, Mode::kPaused);
}

TEST_F(Pause, DisengagedThereIsNothingToPause) {
  rig->physics.timeSlip();
  rest(false, 1);
  EXPECT_EQ(rig->model().mode, Mode::kPedalUp);
}

}  // namespace
}  // namespace raven2_trainer::loop
