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
                            Event::kPlanReady, Event::kPlanFailed, Event::kTimeSlip}) {
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
  for (const Mode moving : {Mode::kTeleoperating, Mode::kPlanning, Mode::kTracking}) {
    EXPECT_EQ(nextMode(moving, Event::kTimeSlip), Mode::kPaused);
  }
  for (const Mode still : {Mode::kWaiting, Mode::kPedalUp, Mode::kStopped, Mode::kPaused}) {
    EXPECT_EQ(nextMode(still, Event::kTimeSlip), still);
  }
}

TEST(ModeTable, OnlyANewPedalDownLeavesThePause) {
  for (const Event event : {Event::kRobotReady, Event::kPedalReleased, Event::kPlanRequested, Event::kPlanReady,
                            Event::kPlanFailed, Event::kStopCleared, Event::kTimeSlip}) {
    EXPECT_EQ(nextMode(Mode::kPaused, event), Mode::kPaused);
  }
  EXPECT_EQ(nextMode(Mode::kPaused, Event::kPedalPressed), Mode::kTeleoperating);
}

}  // namespace
}  // namespace raven2_trainer::control
