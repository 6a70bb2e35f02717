#include "plant/plc.h"

#include <gtest/gtest.h>

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::plant {
namespace {

namespace pins = raven::pins;

/** Output bytes of a healthy program: watchdog square wave of 50 cycles. */
class Software {
 public:
  void run(Plc* plc, int cycles, std::uint8_t other_pins = 0) {
    for (int k = 0; k < cycles; ++k) {
      const bool high = (phase_++ / 25) % 2 == 1;
      const auto out = static_cast<std::uint8_t>(other_pins | (high && alive ? pins::kWatchdog : 0));
      plc->step({out, out});
    }
  }
  bool alive{true};

 private:
  int phase_{0};
};

Plc inPedalDown(Software* software) {
  Plc plc;
  plc.pressStart();
  software->run(&plc, 60);
  software->run(&plc, 1, pins::kReady);
  software->run(&plc, 1, pins::kReady | pins::kFootPedal);
  EXPECT_EQ(plc.level(), RunLevel::kPedalDown);
  return plc;
}

TEST(Plc, StaysInEStopWithoutTheStartButton) {
  Plc plc;
  Software software;
  software.run(&plc, 1000, pins::kReady | pins::kFootPedal);
  EXPECT_EQ(plc.level(), RunLevel::kEStop);
  EXPECT_TRUE(plc.brakesOn());
  EXPECT_FALSE(plc.powered());
}

TEST(Plc, StartButtonWaitsForTheWatchdog) {
  Plc plc;
  plc.pressStart();
  for (int k = 0; k < 1000; ++k)
    plc.step({});
  EXPECT_EQ(plc.level(), RunLevel::kEStop);
  Software software;
  software.run(&plc, 30);
  EXPECT_EQ(plc.level(), RunLevel::kInit);
}

TEST(Plc, ClimbsByReadyAndPedalWithTheBrakesOfEachLevel) {
  Plc plc;
  Software software;
  plc.pressStart();
  software.run(&plc, 60);
  EXPECT_EQ(plc.level(), RunLevel::kInit);
  EXPECT_FALSE(plc.brakesOn());
  software.run(&plc, 1, pins::kReady);
  EXPECT_EQ(plc.level(), RunLevel::kPedalUp);
  EXPECT_TRUE(plc.brakesOn());
  EXPECT_TRUE(plc.powered());
  software.run(&plc, 1, pins::kReady | pins::kFootPedal);
  EXPECT_EQ(plc.level(), RunLevel::kPedalDown);
  EXPECT_FALSE(plc.brakesOn());
  EXPECT_EQ(plc.inputPins(), 0xC0);
  software.run(&plc, 1, pins::kReady);
  EXPECT_EQ(plc.level(), RunLevel::kPedalUp);
}

TEST(Plc, DropsToEStop200CyclesAfterTheLastWatchdogEdge) {
  Software software;
  Plc plc = inPedalDown(&software);
  software.alive = false;
  software.run(&plc, 26, pins::kFootPedal);  // in any phase, no edge comes after this
  int cycles = 26;
  while (plc.level() != RunLevel::kEStop && cycles < 1000) {
    software.run(&plc, 1, pins::kFootPedal);
    ++cycles;
  }
  EXPECT_GE(cycles, 200 - 25);
  EXPECT_LE(cycles, 200 + 25);
}

TEST(Plc, AnEStopLastsUntilStartIsPressedAgain) {
  Software software;
  Plc plc = inPedalDown(&software);
  software.alive = false;
  software.run(&plc, 300);
  software.alive = true;
  software.run(&plc, 5000, pins::kReady | pins::kFootPedal);
  EXPECT_EQ(plc.level(), RunLevel::kEStop);
  plc.pressStart();
  software.run(&plc, 1);
  EXPECT_EQ(plc.level(), RunLevel::kInit);
}

TEST(Plc, OneDeadBoardIsEnough) {
  Software software;
  Plc plc = inPedalDown(&software);
  for (int k = 0; k < 250; ++k) {
    const std::uint8_t wave = (k / 25) % 2 == 1 ? pins::kWatchdog : 0;
    plc.step({wave, 0});
  }
  EXPECT_EQ(plc.level(), RunLevel::kEStop);
}

class PlcBoards : public ::testing::TestWithParam<Arm> {
 protected:
  /** One cycle: `own` on the tested arm's board, `other` on the other one, a watchdog on both. */
  void step(Plc* plc, std::uint8_t own, std::uint8_t other) {
    const std::uint8_t wave = (phase_++ / 25) % 2 == 1 ? pins::kWatchdog : 0;
    PerArm<std::uint8_t> out{};
    at(out, GetParam()) = own | wave;
    at(out, otherArm(GetParam())) = other | wave;
    plc->step(out);
  }
  int phase_{0};
};

TEST_P(PlcBoards, TheWatchdogOfEitherOneIsWatched) {
  Software software;
  Plc plc = inPedalDown(&software);
  int cycles = 0;
  for (; plc.level() != RunLevel::kEStop && cycles < 1000; ++cycles) {
    const std::uint8_t wave = (cycles / 25) % 2 == 1 ? pins::kWatchdog : 0;
    PerArm<std::uint8_t> out{};
    at(out, otherArm(GetParam())) = pins::kFootPedal | wave;
    at(out, GetParam()) = pins::kFootPedal;
    plc.step(out);
  }
  EXPECT_GE(cycles, 200 - 50);
  EXPECT_LE(cycles, 201);
}

TEST_P(PlcBoards, ASignalCountsWhenBothCarryIt) {
  Plc plc;
  plc.pressStart();
  for (int k = 0; k < 60; ++k)
    step(&plc, 0, 0);
  ASSERT_EQ(plc.level(), RunLevel::kInit);
  for (int k = 0; k < 100; ++k)
    step(&plc, pins::kReady, 0);
  EXPECT_EQ(plc.level(), RunLevel::kInit);
  step(&plc, pins::kReady, pins::kReady);
  ASSERT_EQ(plc.level(), RunLevel::kPedalUp);
  for (int k = 0; k < 100; ++k)
    step(&plc, pins::kReady | pins::kFootPedal, pins::kReady);
  EXPECT_EQ(plc.level(), RunLevel::kPedalUp);
  step(&plc, pins::kFootPedal, pins::kFootPedal);
  ASSERT_EQ(plc.level(), RunLevel::kPedalDown);
  step(&plc, pins::kFootPedal, 0);
  EXPECT_EQ(plc.level(), RunLevel::kPedalUp) << "one board without the pedal is enough";
}

INSTANTIATE_TEST_SUITE_P(Arms, PlcBoards, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

TEST(Plc, AStartPressedInOperationDoesNotOutliveAnEStop) {
  Software software;
  Plc plc = inPedalDown(&software);
  plc.pressStart();
  software.run(&plc, 100, pins::kReady | pins::kFootPedal);
  software.alive = false;
  software.run(&plc, 300);
  ASSERT_EQ(plc.level(), RunLevel::kEStop);
  software.alive = true;
  software.run(&plc, 1000, pins::kReady | pins::kFootPedal);
  EXPECT_EQ(plc.level(), RunLevel::kEStop);
}

TEST(Plc, StartingInALevelTakesTheWatchdogsAsJustSeen) {
  Plc plc;
  plc.startIn(RunLevel::kPedalUp);
  int cycles = 0;
  for (; plc.level() != RunLevel::kEStop && cycles < 1000; ++cycles)
    plc.step({});
  EXPECT_EQ(cycles, 200);
}

}  // namespace
}  // namespace raven2_trainer::plant
