#include "raven2_trainer/control/mode_table.h"

#include <gtest/gtest.h>

namespace raven2_trainer::control {
namespace {

TEST(ModeTable, EmergencyStopWinsFromEverywhere) {
  for (std::size_t m = 0; m < kModeCount; ++m) {
    EXPECT_EQ(nextMode(static_cast<Mode>(m), Event::kEmergencyStop), Mode::kStopped);
  }
}

TEST(ModeTable, OnlyTheClearedStopLeavesAStop) {
  for (const Event event : {Event::kRobotReady, Event::kPedalPressed, Event::kPedalReleased, Event::kPlanRequested,
                            Event::kPlanReady, Event::kPlanFailed, Event::kTimeSlip, Event::kGoalWanted,
                            Event::kPlanArmed, Event::kPlanCancelled, Event::kExecutionEnded, Event::kTrialEnded}) {
    EXPECT_EQ(nextMode(Mode::kStopped, event), Mode::kStopped);
  }
  EXPECT_EQ(nextMode(Mode::kStopped, Event::kStopCleared), Mode::kPedalUp);
}

TEST(ModeTable, ThePedalEndsPlanningAndTracking) {
  EXPECT_EQ(nextMode(Mode::kPlanning, Event::kPedalPressed), Mode::kTeleoperating);
  EXPECT_EQ(nextMode(Mode::kTracking, Event::kPedalPressed), Mode::kTeleoperating);
}

TEST(ModeTable, NoPlanWhileTheSurgeonMoves) {
  EXPECT_EQ(nextMode(Mode::kTeleoperating, Event::kPlanRequested), Mode::kTeleoperating);
}

TEST(ModeTable, ALateResultChangesNothing) {
  EXPECT_EQ(nextMode(Mode::kTeleoperating, Event::kPlanReady), Mode::kTeleoperating);
  EXPECT_EQ(nextMode(Mode::kPedalUp, Event::kPlanFailed), Mode::kPedalUp);
}

TEST(ModeTable, LostTimePausesWhateverMovesAndNothingElse) {
  for (const Mode moving :
       {Mode::kTeleoperating, Mode::kPlanning, Mode::kTracking, Mode::kChoosing, Mode::kArmed, Mode::kExecuting}) {
    EXPECT_EQ(nextMode(moving, Event::kTimeSlip), Mode::kPaused);
  }
  for (const Mode still : {Mode::kWaiting, Mode::kPedalUp, Mode::kStopped, Mode::kPaused}) {
    EXPECT_EQ(nextMode(still, Event::kTimeSlip), still);
  }
}

TEST(ModeTable, OnlyANewPedalDownLeavesThePause) {
  for (const Event event : {Event::kRobotReady, Event::kPedalReleased, Event::kPlanRequested, Event::kPlanReady,
                            Event::kPlanFailed, Event::kStopCleared, Event::kTimeSlip, Event::kGoalWanted,
                            Event::kPlanArmed, Event::kPlanCancelled, Event::kExecutionEnded, Event::kTrialEnded}) {
    EXPECT_EQ(nextMode(Mode::kPaused, event), Mode::kPaused);
  }
  EXPECT_EQ(nextMode(Mode::kPaused, Event::kPedalPressed), Mode::kTeleoperating);
}

TEST(ModeTable, OnlyAnArmedPlanIsExecutedAndOnlyByThePedal) {
  for (std::size_t m = 0; m < kModeCount; ++m) {
    const auto mode = static_cast<Mode>(m);
    for (int e = 0; e <= static_cast<int>(Event::kTrialEnded); ++e) {
      const auto event = static_cast<Event>(e);
      if (mode == Mode::kExecuting || nextMode(mode, event) != Mode::kExecuting) continue;
      EXPECT_EQ(mode, Mode::kArmed);
      EXPECT_EQ(event, Event::kPedalPressed);
    }
  }
  EXPECT_EQ(nextMode(Mode::kArmed, Event::kPedalPressed), Mode::kExecuting);
}

TEST(ModeTable, ThePedalIsADeadMansSwitch) {
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kPedalReleased), Mode::kPedalUp);
}

TEST(ModeTable, ArmingTakesAPedalThatIsUp) {
  for (const Mode mode : {Mode::kPedalUp, Mode::kTracking})
    EXPECT_EQ(nextMode(mode, Event::kPlanArmed), Mode::kArmed);
  for (const Mode mode : {Mode::kWaiting, Mode::kTeleoperating, Mode::kPlanning, Mode::kStopped, Mode::kPaused,
                          Mode::kChoosing, Mode::kExecuting})
    EXPECT_EQ(nextMode(mode, Event::kPlanArmed), mode);
}

TEST(ModeTable, ThePedalMovesTheGoalAndNothingElseWhileItIsChosen) {
  EXPECT_EQ(nextMode(Mode::kChoosing, Event::kPedalPressed), Mode::kChoosing);
  EXPECT_EQ(nextMode(Mode::kChoosing, Event::kPedalReleased), Mode::kChoosing);
  EXPECT_EQ(nextMode(Mode::kChoosing, Event::kPlanRequested), Mode::kPlanning);
}

TEST(ModeTable, GivingUpLeavesEveryPartOfPlanningWithThePedalUp) {
  for (const Mode mode : {Mode::kChoosing, Mode::kPlanning, Mode::kArmed, Mode::kExecuting})
    EXPECT_EQ(nextMode(mode, Event::kPlanCancelled), Mode::kPedalUp);
  EXPECT_EQ(nextMode(Mode::kTeleoperating, Event::kPlanCancelled), Mode::kTeleoperating);
}

TEST(ModeTable, AfterATrialTheModelHoldsAfterTheRobotMovedItFollows) {
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kTrialEnded), Mode::kTracking);
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kExecutionEnded), Mode::kPedalUp);
}

TEST(ModeTable, NoPlanWhileOneIsExecuted) {
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kPlanRequested), Mode::kExecuting);
  EXPECT_EQ(nextMode(Mode::kExecuting, Event::kGoalWanted), Mode::kExecuting);
}

}  // namespace
}  // namespace raven2_trainer::control
