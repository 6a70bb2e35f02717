#include "raven2_trainer/control/trial_tape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raven2_trainer::control {
namespace {

/** Joint 0 of both arms, and the gold tip's x, say the number of the tick. */
TrialSample sampleOf(double number) {
  TrialSample sample;
  sample.q_d[0][0] = number;
  sample.q_d[1][0] = -number;
  sample.tip_B[0][0] = 2.0 * number;
  return sample;
}

TrialTape tapeOf(int ticks, std::size_t capacity = 1000) {
  TrialTape tape(capacity);
  for (int i = 0; i < ticks; ++i)
    tape.add(sampleOf(i));
  return tape;
}

ExecutionConfig configuration() {
  ExecutionConfig config;
  config.hold_time = 0.2;
  config.speed = 0.5;  // of plans; a trial has its own time
  return config;
}

TEST(TrialTape, TellsWhatWasKeptTickByTick) {
  const TrialTape tape = tapeOf(10);
  EXPECT_EQ(tape.size(), 10U);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(tape.at(i).q_d[0][0], i);
    EXPECT_EQ(tape.at(i).q_d[1][0], -i);
    EXPECT_EQ(tape.at(i).tip_B[0][0], 2 * i);
  }
}

TEST(TrialTape, IsLinearBetweenTicksAndEndsAtItsEnds) {
  const TrialTape tape = tapeOf(10);
  EXPECT_DOUBLE_EQ(tape.at(3.25).q_d[0][0], 3.25);
  EXPECT_DOUBLE_EQ(tape.at(3.25).q_d[1][0], -3.25);
  EXPECT_DOUBLE_EQ(tape.at(3.25).tip_B[0][0], 6.5);
  EXPECT_EQ(tape.at(-5.0).q_d[0][0], 0.0);
  EXPECT_EQ(tape.at(100.0).q_d[0][0], 9.0);
}

TEST(TrialTape, TakesNoMoreThanItHolds) {
  TrialTape tape = tapeOf(5, 5);
  EXPECT_TRUE(tape.isFull());
  EXPECT_FALSE(tape.add(sampleOf(5)));
  EXPECT_EQ(tape.size(), 5U);
  EXPECT_EQ(tape.at(9.0).q_d[0][0], 4.0);
  tape.clear();
  EXPECT_EQ(tape.size(), 0U);
  EXPECT_TRUE(tape.add(sampleOf(7)));
  EXPECT_EQ(tape.at(0.0).q_d[0][0], 7.0);
}

TEST(TrialTape, AClutchLeavesNoStep) {
  TrialTape tape(1000);
  for (int i = 0; i < 50; ++i)
    tape.add(sampleOf(1.0));
  tape.mark();
  for (int i = 0; i < 200; ++i)
    tape.add(sampleOf(0.0));
  double largest = 0.0;
  for (int i = 1; i < 250; ++i)
    largest = std::max(largest, std::abs(tape.at(i).q_d[0][0] - tape.at(i - 1.0).q_d[0][0]));
  EXPECT_NEAR(largest, 15.0 / 8.0 / 100.0, 1e-3) << "a minimum-jerk step of 100 ticks";
  EXPECT_EQ(tape.at(50.0).q_d[0][0], 1.0);
  EXPECT_NEAR(tape.at(100.0).q_d[0][0], 0.5, 1e-9);
  EXPECT_EQ(tape.at(150.0).q_d[0][0], 0.0);
  EXPECT_EQ(tape.at(60.0).tip_B[0][0], 0.0) << "tip positions do not change";
}

TEST(TrialTape, AClutchWhileOneIsStillSpreadLeavesNoStepEither) {
  TrialTape tape(1000);
  tape.add(sampleOf(1.0));
  for (int clutch = 0; clutch < 4; ++clutch) {
    tape.mark();
    for (int i = 0; i < 30; ++i)
      tape.add(sampleOf(clutch % 2 == 0 ? 0.0 : 3.0));
  }
  for (int i = 1; i < 121; ++i)
    EXPECT_LT(std::abs(tape.at(i).q_d[0][0] - tape.at(i - 1.0).q_d[0][0]), 0.1) << i;
}

TEST(TrialTape, TheFirstPedalDownIsNoClutch) {
  TrialTape tape = tapeOf(5);
  tape.clear();
  tape.mark();
  tape.add(sampleOf(3.0));
  EXPECT_EQ(tape.at(0.0).q_d[0][0], 3.0);
}

TEST(TrialTape, AnotherTrialHasNothingOfTheOneBefore) {
  TrialTape tape(1000);
  for (const double number : {0.0, 3.0}) {  // a clutch, whose step is still spread
    tape.mark();
    for (int i = 0; i < 10; ++i)
      tape.add(sampleOf(number));
  }
  ASSERT_NE(tape.at(15.0).q_d[0][0], 3.0);
  tape.clear();
  for (int i = 0; i < 200; ++i)
    tape.add(sampleOf(5.0));
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(tape.at(i).q_d[0][0], 5.0) << i;
    EXPECT_EQ(tape.at(i).q_d[1][0], -5.0) << i;
  }
}

/** Both arms, every joint and every axis of the tips, all different and all in motion. */
TrialSample fullSample(double number) {
  TrialSample sample;
  for (std::size_t a = 0; a < kArmCount; ++a) {
    const double arm = static_cast<double>(a + 1);
    for (std::size_t j = 0; j < kJointCount; ++j)
      at(sample.q_d, kArms[a])[j] = arm * 0.1 + static_cast<double>(j) + arm * 0.001 * number;
    for (std::size_t i = 0; i < 3; ++i)
      at(sample.tip_B, kArms[a])[i] = arm * (1.0 + static_cast<double>(i)) * 1e-4 * number;
  }
  return sample;
}

void expectNear(const TrialSample& a, const TrialSample& b) {
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_NEAR(at(a.q_d, arm)[j], at(b.q_d, arm)[j], 1e-12) << name(arm) << " " << kJointNames[j];
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(at(a.tip_B, arm)[i], at(b.tip_B, arm)[i], 1e-12) << name(arm) << " " << i;
  }
}

TEST(TrialTape, KeepsEveryJointAndTipOfBothArmsBetweenTicksToo) {
  TrialTape tape(10);
  for (int i = 0; i < 10; ++i)
    tape.add(fullSample(i));
  for (const double ticks : {0.0, 3.0, 3.25, 8.75, 9.0})
    expectNear(tape.at(ticks), fullSample(ticks));
}

TEST(TapeExecution, AnotherStartIsAsTheFirst) {
  const TrialTape tape = tapeOf(300), other = tapeOf(20);
  for (const int ticks : {1, 150, 350, 600}) {
    TapeExecution used(configuration()), fresh(configuration());
    used.start(tape, sampleOf(4.0).q_d);
    for (int i = 0; i < ticks; ++i)
      used.tick(true);
    for (int i = 0; i < 7; ++i)
      used.tick(false);
    used.start(other, sampleOf(2.0).q_d);
    fresh.start(other, sampleOf(2.0).q_d);
    for (int i = 0; i < 300; ++i) {
      ASSERT_EQ(used.desired().q_d, fresh.desired().q_d) << ticks << ", tick " << i;
      ASSERT_EQ(used.desired().tip_B, fresh.desired().tip_B) << ticks << ", tick " << i;
      ASSERT_EQ(used.progress(), fresh.progress());
      ASSERT_EQ(used.waited(), fresh.waited());
      ASSERT_EQ(used.rested(), fresh.rested());
      used.tick(true);
      fresh.tick(true);
    }
    EXPECT_EQ(used.goal(), fresh.goal());
  }
}

TEST(TapeExecution, LeadsBothArmsFromWhereTheyStand) {
  const TrialTape tape = tapeOf(300);
  TapeExecution execution(configuration());
  execution.start(tape, {JointArray{7.0}, JointArray{-3.0}});
  for (int i = 0; i < 100; ++i)
    execution.tick(true);
  EXPECT_NEAR(execution.desired().q_d[0][0], 3.5, 1e-9) << "half of the distance after half of the hold";
  EXPECT_NEAR(execution.desired().q_d[1][0], -1.5, 1e-9);
}

TEST(TapeExecution, HoldsThenPlaysInItsOwnTimeThenRests) {
  const TrialTape tape = tapeOf(300);
  TapeExecution execution(configuration());
  TrialSample from = sampleOf(0.0);
  from.q_d[0][1] = 0.4;  // away from the start of the tape
  execution.start(tape, from.q_d);
  EXPECT_EQ(execution.desired().q_d, from.q_d);
  double before = 0.4;
  for (int i = 0; i < 200; ++i) {
    const TrialSample& now = execution.tick(true);
    EXPECT_LE(now.q_d[0][1], before);
    before = now.q_d[0][1];
    EXPECT_EQ(now.q_d[0][0], 0.0);
    EXPECT_EQ(execution.progress(), 0.0);
  }
  EXPECT_NEAR(before, 0.0, 1e-12);
  for (int i = 1; i <= 299; ++i) {
    EXPECT_FALSE(execution.isOver());
    EXPECT_NEAR(execution.tick(true).q_d[0][0], i, 1e-9);
    EXPECT_NEAR(execution.desired().tip_B[0][0], 2.0 * i, 1e-9);
  }
  EXPECT_TRUE(execution.isOver());
  EXPECT_EQ(execution.progress(), 1.0);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(execution.tick(true).q_d[0][0], 299.0);
  EXPECT_NEAR(execution.rested(), 0.010, 1e-12);
  EXPECT_EQ(execution.goal()[0][0], 299.0);
}

TEST(TapeExecution, StandsStillWhereItMayNotMoveAndComesUpToSpeedAgain) {
  const TrialTape tape = tapeOf(900);
  TapeExecution execution(configuration());
  execution.start(tape, tape.at(0.0).q_d);
  for (int i = 0; i < 400; ++i)
    execution.tick(true);
  const double stood = execution.desired().q_d[0][0];
  EXPECT_NEAR(stood, 200.0, 1e-9);
  for (int i = 0; i < 30; ++i)
    EXPECT_EQ(execution.tick(false).q_d[0][0], stood);
  EXPECT_NEAR(execution.waited(), 0.030, 1e-12);
  double step = 0.0, before = stood;
  for (int i = 0; i < 100; ++i) {
    const double now = execution.tick(true).q_d[0][0];
    EXPECT_GT(now - before, step) << "faster and faster";
    step = now - before;
    before = now;
  }
  EXPECT_NEAR(step, 1.0, 1e-9);
  EXPECT_NEAR(execution.tick(true).q_d[0][0] - before, 1.0, 1e-9) << "and no faster";
  EXPECT_EQ(execution.waited(), 0.0);
}

}  // namespace
}  // namespace raven2_trainer::control
