#include "raven/state_machine.h"

#include <gtest/gtest.h>

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::raven {
namespace {

constexpr std::uint8_t pinsOf(RunLevel level) {
  return static_cast<std::uint8_t>(static_cast<unsigned>(level) << pins::kLevelShift);
}

void read(StateMachine* machine, RunLevel gold, RunLevel green) {
  machine->follow(StateMachine::levelOf(pinsOf(gold), pinsOf(green)));
}

/** The output pins to the PLC when nothing is wrong. */
std::uint8_t outputPins(StateMachine* machine, bool pedal) {
  return machine->outputPins({pedal, machine->runLevel(), machine->initialized()});
}

StateMachine inInit() {
  StateMachine machine;
  for (int k = 0; k < 4; ++k)
    read(&machine, RunLevel::kInit, RunLevel::kInit);
  return machine;
}

TEST(StateMachine, ChangeCountsOnTheFourthDifferingCycle) {
  StateMachine machine;
  for (int k = 0; k < 3; ++k) {
    read(&machine, RunLevel::kInit, RunLevel::kInit);
    EXPECT_EQ(machine.runLevel(), RunLevel::kEStop);
  }
  read(&machine, RunLevel::kInit, RunLevel::kInit);
  EXPECT_EQ(machine.runLevel(), RunLevel::kInit);
}

TEST(StateMachine, DifferingCyclesAreNotForgottenOnAgreement) {
  StateMachine machine;
  for (int k = 0; k < 3; ++k) {
    read(&machine, RunLevel::kInit, RunLevel::kInit);
    for (int m = 0; m < 10; ++m)
      read(&machine, RunLevel::kEStop, RunLevel::kEStop);
  }
  read(&machine, RunLevel::kInit, RunLevel::kInit);
  EXPECT_EQ(machine.runLevel(), RunLevel::kInit);
}

TEST(StateMachine, LowestLevelOfBothArmsWins) {
  StateMachine machine;
  for (int k = 0; k < 4; ++k)
    read(&machine, RunLevel::kPedalDown, RunLevel::kPedalUp);
  EXPECT_EQ(machine.runLevel(), RunLevel::kPedalUp);
  for (int k = 0; k < 4; ++k)
    read(&machine, RunLevel::kEStop, RunLevel::kPedalUp);
  EXPECT_EQ(machine.runLevel(), RunLevel::kEStop);
}

TEST(StateMachine, SubLevelsTakeOneOneAndElevenCycles) {
  StateMachine machine = inInit();
  std::array<int, 4> cycles_in{};
  for (int k = 0; k < 20; ++k) {
    ++cycles_in[machine.subLevel()];
    machine.step(false);
  }
  EXPECT_EQ(cycles_in[0], 1);
  EXPECT_EQ(cycles_in[1], 1);
  EXPECT_EQ(cycles_in[2], 11);
  EXPECT_EQ(machine.subLevel(), 3);
}

TEST(StateMachine, ReadyOnlyOnceHomed) {
  StateMachine machine = inInit();
  for (int k = 0; k < 100; ++k)
    machine.step(false);
  EXPECT_TRUE(machine.mayHome());
  EXPECT_EQ(outputPins(&machine, false) & pins::kReady, 0);
  machine.step(true);
  EXPECT_FALSE(machine.mayHome());
  EXPECT_NE(outputPins(&machine, false) & pins::kReady, 0);
}

TEST(StateMachine, EStopClearsReadySubLevelAndSoftEStop) {
  StateMachine machine = inInit();
  for (int k = 0; k < 20; ++k)
    machine.step(true);
  machine.softEstop();
  for (int k = 0; k < 4; ++k)
    read(&machine, RunLevel::kEStop, RunLevel::kEStop);
  machine.step(true);
  EXPECT_FALSE(machine.initialized());
  EXPECT_FALSE(machine.softEstopped());
  EXPECT_EQ(machine.subLevel(), 0);
}

TEST(StateMachine, PedalReachesThePlcAboveInitOnly) {
  StateMachine machine = inInit();
  EXPECT_EQ(outputPins(&machine, true) & (pins::kFootPedal | pins::kLevelMask), 1);
  for (int k = 0; k < 4; ++k)
    read(&machine, RunLevel::kPedalUp, RunLevel::kPedalUp);
  EXPECT_EQ(outputPins(&machine, true) & (pins::kFootPedal | pins::kLevelMask), 2 | pins::kFootPedal);
  EXPECT_EQ(outputPins(&machine, false) & pins::kFootPedal, 0);
}

TEST(StateMachine, WatchdogIsASquareWaveOfFiftyCyclesAndLowInSoftEStop) {
  StateMachine machine;
  int edges = 0, high = 0;
  bool last = false;
  for (int k = 0; k < 500; ++k) {
    const bool level = (outputPins(&machine, false) & pins::kWatchdog) != 0;
    edges += level != last ? 1 : 0;
    high += level ? 1 : 0;
    last = level;
  }
  EXPECT_EQ(edges, 20);
  EXPECT_EQ(high, 250);
  machine.softEstop();
  for (int k = 0; k < 100; ++k)
    EXPECT_EQ(outputPins(&machine, false) & pins::kWatchdog, 0);
}

TEST(StateMachine, EveryAttemptTakesAsLongAsTheFirst) {
  StateMachine machine;
  for (int attempt = 0; attempt < 3; ++attempt) {
    for (const RunLevel level : {RunLevel::kInit, RunLevel::kEStop}) {
      const RunLevel before = machine.runLevel();
      for (int k = 0; k < 3; ++k) {
        read(&machine, level, level);
        EXPECT_EQ(machine.runLevel(), before) << attempt;
      }
      read(&machine, level, level);
      ASSERT_EQ(machine.runLevel(), level) << attempt;
      int cycles = 0;
      for (; level == RunLevel::kInit && machine.subLevel() != 3; ++cycles)
        machine.step(false);
      EXPECT_EQ(cycles, level == RunLevel::kInit ? 1 + 1 + 11 : 0) << attempt;
      machine.step(false);
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::raven
