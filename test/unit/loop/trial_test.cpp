#include <gtest/gtest.h>

#include <cstdio>

#include "raven2_trainer/core/random.h"
#include "support/effort.h"
#include "support/mode_driver.h"

// Tests virtual trials and their repetition on model and robot: doc/modes.md.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::apart;
using raven2_trainer::testing::effort;
using raven2_trainer::testing::goldTowards;
using raven2_trainer::testing::ModeDriver;

class Trial : public ::testing::Test {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    d = std::make_unique<ModeDriver>();
    ASSERT_TRUE(d->begin());
    tips.clear();
  }

  /** Runs a trial of some 2 s: forward, a clutch in motion, further forward, a grasp, and part of the return. */
  void tryIt() {
    ASSERT_EQ(d->ask(RequestKind::kBeginTrial), PlanningAnswer::kAccepted);
    ASSERT_EQ(d->mode(), Mode::kTrialHeld);
    d->watch = [this] {
      if (d->mode() == Mode::kTrial) tips.push_back({d->modelTip(Arm::kGold), d->modelTip(Arm::kGreen)});
    };
    d->stroke(400, 0.5);
    for (int i = 0; i < 200; ++i)  // the pedal goes up in the middle of a stroke
      d->tick(command(10e-6));
    d->rest(false, 150);
    d->stroke(400, 0.5, 0.004);
    d->rest(true, 100);
    d->rest(false, 100);
    d->stroke(600, -0.3);
    d->rest(true, 400);
    d->rest(false, 50);
    d->watch = nullptr;
    ASSERT_EQ(d->rig.model().trial_ticks, tips.size());
    ASSERT_GT(tips.size(), 1900U);
    ASSERT_EQ(d->ask(RequestKind::kEndTrial), PlanningAnswer::kAccepted);
    ASSERT_EQ(d->mode(), Mode::kTrialReady);
  }

  /** Runs a trial of half a second: forward, then the pedal up. */
  void tryBriefly() {
    ASSERT_EQ(d->ask(RequestKind::kBeginTrial), PlanningAnswer::kAccepted);
    d->stroke(400, 0.5);
    d->rest(false, 50);
    ASSERT_EQ(d->ask(RequestKind::kEndTrial), PlanningAnswer::kAccepted);
    ASSERT_EQ(d->mode(), Mode::kTrialReady);
  }

  static MasterCommand command(double speed) {
    MasterCommand sent;
    sent.pedal = 1;
    sent.dp_I = {Vec3{speed, 0.0, 0.0}, Vec3{speed, 0.0, 0.0}};
    return sent;
  }

  void arm(bool on_robot) {
    ASSERT_EQ(d->ask(RequestKind::kRepeatTrial, false, on_robot ? 1 : 0), PlanningAnswer::kAccepted);
    ASSERT_EQ(d->mode(), Mode::kReturning);
    ASSERT_TRUE(d->waitFor(Mode::kArmed));
    ASSERT_EQ(d->rig.model().planning.status, PlanningStatus::kArmed);
    d->rest(false, 20);
  }

  /** Holds the pedal until the repetition ends, and compares the tips with those of the trial. */
  void hold(bool on_robot) {
    model_error = robot_error = 0.0;
    int counted = 0;
    for (int i = 0; i < 12000; ++i) {
      d->rest(true, 1);
      if (d->mode() != Mode::kExecuting) break;
      const double place = d->rig.model().planning.progress * static_cast<double>(tips.size() - 1);
      if (place <= 0.0 || place >= static_cast<double>(tips.size() - 1)) continue;
      const auto& then = tips[static_cast<std::size_t>(std::lround(place))];
      ++counted;
      for (const Arm each : kArms) {
        model_error += apart(d->modelTip(each), at(then, each)) / 2.0;
        if (on_robot) robot_error += apart(d->trueTip(each), at(then, each)) / 2.0;
      }
    }
    ASSERT_GT(counted, static_cast<int>(tips.size()) - 10);
    model_error /= counted;
    robot_error /= counted;
  }

  std::unique_ptr<ModeDriver> d;
  std::vector<PerArm<Vec3>> tips;  ///< of the model, for each tick of the trial
  double model_error{0.0}, robot_error{0.0};
};

TEST_F(Trial, TheRobotKnowsNothingOfItAndWhatIsDoneIsKept) {
  const Vec3 stood = d->robotTip();
  tryIt();
  EXPECT_LT(apart(d->robotTip(), stood), 1e-6);
  EXPECT_GT(d->rig.error(Arm::kGold), 3e-3);
  d->rest(true, 100);
  EXPECT_EQ(d->mode(), Mode::kTrialReady) << "a trial that has ended stays ended";
  EXPECT_EQ(d->rig.model().trial_ticks, tips.size());
}

TEST_F(Trial, IsRepeatedOnTheModelAndThenOnTheRobot) {
  tryIt();
  const Vec3 stood = d->robotTip();
  arm(/*on_robot=*/false);
  hold(false);
  EXPECT_EQ(d->report().end, ExecutionEnd::kFinished);
  EXPECT_EQ(d->report().plan, 0U);
  EXPECT_EQ(d->report().on_robot, 0);
  EXPECT_EQ(d->mode(), Mode::kTrialReady);
  EXPECT_LT(apart(d->robotTip(), stood), 0.5e-3);
  EXPECT_LT(model_error, 1e-3);
  std::printf("model alone: %.3f mm mean\n", model_error * 1e3);
  d->rest(false, 20);
  // WHEN the repetition on the model was satisfactory
  arm(/*on_robot=*/true);
  d->rest(true, 150);  // moves to the start; the robot's jaws sag by 0.2 rad once its brakes are off
  const double jaws = kinematics::jawOpening(d->rig.plant.jointPositions(Arm::kGold));
  hold(true);
  EXPECT_EQ(d->report().end, ExecutionEnd::kFinished);
  EXPECT_EQ(d->report().on_robot, 1);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  EXPECT_LT(model_error, 3e-3);
  EXPECT_LT(robot_error, 3e-3);
  EXPECT_LT(d->report().robot.mean, 3e-3);
  EXPECT_EQ(d->rig.robot().itp.rejectedTotal(), 0U);
  for (const Arm each : kArms) {
    EXPECT_LT(apart(d->trueTip(each), at(tips.back(), each)), 1.5e-3) << "it ends where the trial ended";
    EXPECT_LT(d->rig.error(each), 1e-3);
  }
  const double closed = jaws - kinematics::jawOpening(d->rig.plant.jointPositions(Arm::kGold));
  EXPECT_NEAR(closed, 40 * 0.004, 0.06) << "and the jaws closed as in the trial";
  std::printf("with the robot: model %.3f mm, robot %.3f mm mean; report %.3f mean, %.3f largest\n", model_error * 1e3,
              robot_error * 1e3, d->report().robot.mean * 1e3, d->report().robot.largest * 1e3);
}

TEST_F(Trial, ReleaseAtAnyMomentStopsBothWithinTwentyMilliseconds) {
  Random random(11);
  double worst = 0.0;
  const auto releases = static_cast<int>(effort(4, 10));
  for (int release = 0; release < releases; ++release) {
    SetUp();
    tryIt();
    arm(true);
    const double part = (static_cast<double>(tips.size()) - 250.0) / releases;  // one release in each part
    d->rest(true, static_cast<int>(250.0 + part * random.uniform(release, release + 1.0)));
    ASSERT_EQ(d->mode(), Mode::kExecuting) << release;
    d->rest(false, 1);
    ASSERT_EQ(d->rig.last_relay.command.pedal, 0) << "the robot's pedal goes up in the same tick";
    ASSERT_EQ(d->rig.last_relay.command.dp_I[0], Vec3{});
    ASSERT_EQ(d->mode(), Mode::kPedalUp);
    ASSERT_EQ(d->report().end, ExecutionEnd::kReleased);
    d->rest(false, 19);
    const PerArm<JointArray> stopped{d->rig.plant.jointPositions(Arm::kGold), d->rig.plant.jointPositions(Arm::kGreen)};
    const PerArm<Vec3> tip{d->trueTip(Arm::kGold), d->trueTip(Arm::kGreen)};
    for (int i = 0; i < 200; ++i) {
      d->rest(false, 1);
      for (const Arm each : kArms) {
        worst = std::max(worst, apart(d->trueTip(each), at(tip, each)));
        for (std::size_t j = 0; j <= kInsertion; ++j)  // joints with brakes; the tool's joints coast for 40 ms
          ASSERT_NEAR(d->rig.plant.jointPositions(each)[j], at(stopped, each)[j], 1e-5) << kJointNames[j];
      }
    }
    EXPECT_LT(d->rig.error(Arm::kGold), 0.1e-3) << "the model is where the robot is";
    EXPECT_EQ(d->rig.model().trial_ticks, 0U) << "the robot has left the start of the trial";
  }
  EXPECT_LT(worst, 0.3e-3);
  std::printf("true tips moved %.4f mm from 20 ms after the release on\n", worst * 1e3);
}

TEST_F(Trial, ATapeThatIsFullEndsIt) {
  constexpr double kShort = 2.0;
  EXPECT_EQ(kTrialLimit, 120.0);
  d = std::make_unique<ModeDriver>(ModeDriver::configuration(), kShort);
  ASSERT_TRUE(d->begin());
  d->ask(RequestKind::kBeginTrial);
  const int whole = static_cast<int>(kShort / kTickSeconds);
  d->rest(true, whole - 100);
  ASSERT_EQ(d->mode(), Mode::kTrial);
  d->stroke(300, 1.0);
  EXPECT_EQ(d->mode(), Mode::kTrialReady);
  EXPECT_EQ(d->rig.model().trial_ticks, static_cast<std::uint32_t>(whole));
  const Vec3 held = d->modelTip();
  d->stroke(300, 1.0);
  EXPECT_LT(apart(d->modelTip(), held), 1e-3) << "motion that is not recorded does not move the model";
}

TEST_F(Trial, DiscardedItIsForgottenAndTheModelGoesBack) {
  tryIt();
  EXPECT_EQ(d->ask(RequestKind::kDiscardTrial), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kReturning);
  EXPECT_TRUE(d->waitFor(Mode::kPedalUp));
  d->rest(false, 2);
  EXPECT_EQ(d->rig.model().trial_ticks, 0U);
  EXPECT_LT(d->rig.error(Arm::kGold), 0.1e-3);
  EXPECT_EQ(d->ask(RequestKind::kRepeatTrial), PlanningAnswer::kNotNow);
}

TEST_F(Trial, DiscardedItLeavesNothingBehind) {
  const auto before = d->rig.model().bodies;
  d->ask(RequestKind::kBeginTrial);
  const auto moved = [&] { return apart(d->rig.model().bodies[0].p, before[0].p); };
  for (int i = 0; i < 6000 && moved() < 2e-3; ++i)
    d->tick(goldTowards(d->rig, before[0].p));
  ASSERT_GT(moved(), 2e-3) << "the tool must have moved the ring";
  d->rest(false, 50);
  ASSERT_EQ(d->ask(RequestKind::kDiscardTrial), PlanningAnswer::kAccepted);
  ASSERT_TRUE(d->waitFor(Mode::kPedalUp));
  EXPECT_LT(moved(), 1e-5);
}

TEST_F(Trial, ItsRepetitionFindsTheSceneAsTheTrialDid) {
  const auto before = d->rig.model().bodies;
  const auto moved = [&] { return apart(d->rig.model().bodies[0].p, before[0].p); };
  ASSERT_EQ(d->ask(RequestKind::kBeginTrial), PlanningAnswer::kAccepted);
  for (int i = 0; i < 6000 && moved() < 2e-3; ++i)
    d->tick(goldTowards(d->rig, before[0].p));
  ASSERT_GT(moved(), 2e-3) << "the tool must have moved the ring";
  d->rest(false, 50);
  ASSERT_EQ(d->ask(RequestKind::kEndTrial), PlanningAnswer::kAccepted);
  arm(/*on_robot=*/false);
  EXPECT_LT(moved(), 1e-5);
}

TEST_F(Trial, NorDoesOneThatAStopEnded) {
  const auto before = d->rig.model().bodies;
  const auto moved = [&] { return apart(d->rig.model().bodies[0].p, before[0].p); };
  for (const bool discarded : {true, false}) {
    ASSERT_EQ(d->ask(RequestKind::kBeginTrial), PlanningAnswer::kAccepted);
    for (int i = 0; i < 6000 && moved() < 2e-3; ++i)
      d->tick(goldTowards(d->rig, before[0].p));
    ASSERT_GT(moved(), 2e-3) << "the tool must have moved the ring";
    d->rest(false, 50);
    if (discarded) {
      ASSERT_EQ(d->ask(RequestKind::kDiscardTrial), PlanningAnswer::kAccepted);
      d->rest(false, 20);
      ASSERT_EQ(d->mode(), Mode::kReturning);
    }
    d->ask(RequestKind::kEmergencyStop);
    d->rest(false, 50);
    ASSERT_EQ(d->mode(), Mode::kStopped);
    EXPECT_GT(moved(), 1e-4) << "the arms are in the ring's place";
    ASSERT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kAccepted);
    ASSERT_TRUE(d->waitFor(Mode::kPedalUp));
    EXPECT_LT(moved(), 1e-5) << discarded;
  }
}

TEST_F(Trial, ItsRepetitionIsRefusedWhereItCannotBe) {
  EXPECT_EQ(d->ask(RequestKind::kRepeatTrial), PlanningAnswer::kNotNow) << "there is no trial";
  d->ask(RequestKind::kBeginTrial);
  EXPECT_EQ(d->ask(RequestKind::kRepeatTrial), PlanningAnswer::kNotNow) << "the trial has not ended";
  d->ask(RequestKind::kEndTrial);
  EXPECT_EQ(d->ask(RequestKind::kRepeatTrial), PlanningAnswer::kNoPlan) << "the trial is empty";
  d->ask(RequestKind::kDiscardTrial);
  ASSERT_TRUE(d->waitFor(Mode::kPedalUp));
  tryIt();
  EXPECT_EQ(d->ask(RequestKind::kRepeatTrial, true), PlanningAnswer::kNotNow) << "the pedal is down";
  d->rest(false, 5);
  d->ask(RequestKind::kDisengage);
  EXPECT_EQ(d->ask(RequestKind::kRepeatTrial, false, 1), PlanningAnswer::kNoRobot);
  d->ask(RequestKind::kEngage);
  RobotState elsewhere = d->rig.robot();
  elsewhere.arms[1].q[kElbow] += 0.03;
  d->rig.hear(&elsewhere);
  EXPECT_EQ(d->ask(RequestKind::kRepeatTrial, false, 1), PlanningAnswer::kMoved);
  EXPECT_EQ(d->mode(), Mode::kTrialReady);
}

TEST_F(Trial, APedalThatIsDownAlreadyRepeatsNothing) {
  tryBriefly();
  ASSERT_EQ(d->ask(RequestKind::kRepeatTrial, false, 1), PlanningAnswer::kAccepted);
  d->rest(true, 2000);
  EXPECT_EQ(d->mode(), Mode::kReturning);
  EXPECT_EQ(d->rig.last_relay.command.pedal, 0);
  d->rest(false, 5);
  EXPECT_EQ(d->mode(), Mode::kArmed);
  d->rest(true, 5);
  EXPECT_EQ(d->mode(), Mode::kExecuting);
}

TEST_F(Trial, WhateverEndsItOnItsWayIsReported) {
  const auto begun = [this] {
    SetUp();
    tryBriefly();
    ASSERT_EQ(d->ask(RequestKind::kRepeatTrial, false, 1), PlanningAnswer::kAccepted);
    d->rest(false, 20);
    ASSERT_EQ(d->mode(), Mode::kReturning);
  };
  begun();
  d->ask(RequestKind::kEmergencyStop);
  EXPECT_EQ(d->report().end, ExecutionEnd::kEStop);
  EXPECT_EQ(d->report().started, -1);
  EXPECT_EQ(d->mode(), Mode::kStopped);
  begun();
  d->ask(RequestKind::kCancelPlan);
  EXPECT_EQ(d->report().end, ExecutionEnd::kCancelled);
  EXPECT_TRUE(d->waitFor(Mode::kPedalUp));
  begun();
  d->rig.robot_connected = false;
  d->rig.link.disconnected();
  d->rest(false, 5);
  EXPECT_EQ(d->report().end, ExecutionEnd::kRobotLost);
  begun();
  ASSERT_TRUE(d->waitFor(Mode::kArmed));
  d->rest(true, 300);
  ASSERT_EQ(d->mode(), Mode::kExecuting);
  d->rig.physics.timeSlip();
  d->rest(true, 1);
  EXPECT_EQ(d->report().end, ExecutionEnd::kTimeSlip);
  EXPECT_EQ(d->mode(), Mode::kPaused);
  EXPECT_EQ(d->rig.last_relay.command.pedal, 0);
}

TEST_F(Trial, WithoutARobotItGoesBackToWhereItBegan) {
  d->rig.robot_connected = false;
  d->rig.link.disconnected();
  d->rest(false, 700);
  const Vec3 stood = d->modelTip();
  tryIt();
  arm(false);
  EXPECT_LT(apart(d->modelTip(), stood), 0.5e-3);
  hold(false);
  EXPECT_EQ(d->report().end, ExecutionEnd::kFinished);
  EXPECT_LT(model_error, 1e-3);
}

TEST_F(Trial, WithoutARobotTheJawsComeBackAsTheTrialFoundThem) {
  d->rig.robot_connected = false;
  d->rig.link.disconnected();
  d->rest(false, 700);
  const double at_first = kinematics::jawOpening(d->rig.model().arms[0].q_d);
  d->stroke(300, 1.0, 0.02);  // the jaws close before the trial
  d->rest(false, 60);
  const double before = kinematics::jawOpening(d->rig.model().arms[0].q_d);
  ASSERT_LT(before, at_first - 0.3);
  ASSERT_EQ(d->ask(RequestKind::kBeginTrial), PlanningAnswer::kAccepted);
  d->stroke(300, 1.0, -0.01);
  d->rest(false, 60);
  ASSERT_GT(kinematics::jawOpening(d->rig.model().arms[0].q_d), before + 0.2);
  ASSERT_EQ(d->ask(RequestKind::kDiscardTrial), PlanningAnswer::kAccepted);
  ASSERT_TRUE(d->waitFor(Mode::kPedalUp));
  EXPECT_NEAR(kinematics::jawOpening(d->rig.model().arms[0].q_d), before, 1e-9);
}

TEST_F(Trial, TheSameHandsGiveTheSameTicks) {
  std::vector<ModelState> first;
  for (int run = 0; run < 2; ++run) {
    SetUp();
    std::size_t tick = 0;
    const auto look = [&] {
      const ModelState now = d->rig.model();
      if (run == 0) return first.push_back(now);
      ASSERT_LT(tick, first.size());
      for (const Arm each : kArms) {
        ASSERT_EQ(at(now.arms, each).q, at(first[tick].arms, each).q);
        ASSERT_EQ(at(now.arms, each).q_d, at(first[tick].arms, each).q_d);
      }
      ASSERT_EQ(now.mode, first[tick].mode);
      ++tick;
    };
    tryIt();
    d->watch = look;
    arm(true);
    d->rest(true, 800);
    d->rest(false, 100);
    d->watch = nullptr;
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
