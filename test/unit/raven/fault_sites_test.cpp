#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/core/fault_variables.h"
#include "unit/raven/raven_fixture.h"

// One test for each place in the control program: a wrong input there appears where the program uses it.

namespace raven2_trainer::raven {
namespace {

using test::Bench;

/** On the gold arm, from the next cycle until cleared. */
Fault now(FaultVariable variable, FaultKind kind, double value, int channel = -1) {
  Fault fault;
  fault.id = 5;
  fault.site = infoOf(variable).site;
  fault.variable = variable;
  fault.kind = kind;
  fault.trigger = FaultTrigger::kHand;
  fault.arm = infoOf(variable).per_arm ? 0 : -1;
  fault.channel = static_cast<std::int8_t>(channel);
  fault.value = value;
  return fault;
}

void arm(Bench* bench, const Fault& fault) {
  static std::uint64_t generation = 0;
  FaultPlan plan;
  plan.generation = ++generation;
  plan.count = 1;
  plan.faults[0] = fault;
  ASSERT_TRUE(isSound(fault));
  bench->software.setFaults(plan);
}

/** Homed, pedal down, at rest, under the fault for 20 cycles. */
struct Struck : Bench {
  explicit Struck(const Fault& fault, RunLevel level = RunLevel::kPedalDown) {
    bringTo(level);
    arm(this, fault);
    cycles(20);
  }
  const RobotArmState& gold() const { return at(software.state().arms, Arm::kGold); }
  const RavenReport& report() const { return software.report(); }
};

TEST(FaultSites, AReadThatFailsLeavesTheOldCounts) {
  for (const Fault& fault : {now(FaultVariable::kReadResult, FaultKind::kStuckAt, UsbRead::kNoDevice),
                             now(FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, 2),
                             now(FaultVariable::kGetBoardCount, FaultKind::kStuckAt, 0)}) {
    Struck bench(fault);
    const double before = bench.gold().q[kShoulder];
    bench.q[0][kShoulder] += 0.1;
    bench.cycles(5);
    EXPECT_EQ(bench.gold().q[kShoulder], before) << infoOf(fault.variable).name;
    EXPECT_EQ(bench.software.usbReadErrors() > 0, fault.variable != FaultVariable::kGetBoardCount);
  }
}

TEST(FaultSites, OneBoardReadIsGoldAlone) {
  Struck bench(now(FaultVariable::kGetBoardCount, FaultKind::kStuckAt, 1));
  bench.q[0][kShoulder] += 0.1;
  bench.q[1][kShoulder] += 0.1;
  const double green = at(bench.software.state().arms, Arm::kGreen).q[kShoulder];
  const double gold = bench.gold().q[kShoulder];
  bench.cycles(5);
  EXPECT_EQ(at(bench.software.state().arms, Arm::kGreen).q[kShoulder], green);
  EXPECT_NEAR(bench.gold().q[kShoulder], gold + 0.1, 1e-3);
}

TEST(FaultSites, TheOtherBoardsCountsAreTakenForGolds) {
  Struck bench(now(FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, 1));
  bench.q[1][kShoulder] += 0.05;
  bench.cycles(5);
  const double moved = bench.gold().motor[kShoulder];
  bench.q[1][kShoulder] += 0.05;
  bench.cycles(5);
  EXPECT_GT(std::abs(bench.gold().motor[kShoulder] - moved), 1.0);
}

TEST(FaultSites, BytesOfTheBufferAreCounts) {
  Bench clean;
  clean.bringTo(RunLevel::kPedalDown);
  // Byte 1 of channel 0 is worth 256 counts.
  Fault fault = now(FaultVariable::kBuffer, FaultKind::kAdd, 1, 1);
  Struck bench(fault, RunLevel::kPedalUp);
  EXPECT_NEAR(std::abs(bench.gold().motor[kShoulder] - at(clean.software.state().arms, Arm::kGold).motor[kShoulder]),
              256 * 2 * kPi / 4000, 1e-9);
}

TEST(FaultSites, InputsAndWantedLevelDecideTheRunLevel) {
  EXPECT_EQ(Struck(now(FaultVariable::kInputs, FaultKind::kStuckAt, 0)).level(), RunLevel::kEStop);
  EXPECT_EQ(Struck(now(FaultVariable::kRunLevelDesired, FaultKind::kStuckAt, 1)).level(), RunLevel::kInit);
  EXPECT_EQ(Struck(now(FaultVariable::kPlcState, FaultKind::kStuckAt, 0)).level(), RunLevel::kPedalDown)
      << "only shown";
}

TEST(FaultSites, EstimatesAreWhatTheControllerActsOn) {
  Struck position(now(FaultVariable::kMpos, FaultKind::kAdd, 0.5, kShoulder));
  EXPECT_NE(position.out[0].dac[0], 0);
  Struck velocity(now(FaultVariable::kMvel, FaultKind::kStuckAt, 100.0, kShoulder));
  EXPECT_EQ(velocity.report().mvel[0], 100.0);
  EXPECT_NE(velocity.out[0].dac[0],
            Struck(now(FaultVariable::kMvel, FaultKind::kStuckAt, -100.0, kShoulder)).out[0].dac[0]);
}

TEST(FaultSites, JointsAndTipAreWhatTheyAreToldToBe) {
  EXPECT_EQ(Struck(now(FaultVariable::kJpos, FaultKind::kStuckAt, 0.7, kElbow), RunLevel::kPedalUp).gold().q[kElbow],
            0.7);
  EXPECT_EQ(Struck(now(FaultVariable::kJvel, FaultKind::kStuckAt, 3.0, kElbow)).gold().dq[kElbow], 3.0);
  EXPECT_EQ(Struck(now(FaultVariable::kPos, FaultKind::kStuckAt, 1000, 2), RunLevel::kPedalUp).report().pos_um[2],
            1000);
  const RavenReport turned =
      Struck(now(FaultVariable::kOri, FaultKind::kStuckAt, 0.0, -1), RunLevel::kPedalUp).report();
  EXPECT_TRUE(std::isnan(turned.ori[0]) || turned.ori[0] == 1.0F) << "a matrix of zeros turns nothing";
}

TEST(FaultSites, WantedPosesReachTheMotors) {
  Bench clean;
  clean.bringTo(RunLevel::kPedalDown);
  clean.cycles(20);
  const std::int16_t at_rest = clean.out[0].dac[0];
  EXPECT_NE(Struck(now(FaultVariable::kPosD, FaultKind::kAdd, 3000, 0)).report().pos_d_um[0],
            clean.software.report().pos_d_um[0]);
  EXPECT_NE(Struck(now(FaultVariable::kJposD, FaultKind::kAdd, 0.02, kShoulder)).out[0].dac[0], at_rest);
  EXPECT_NE(Struck(now(FaultVariable::kMposD, FaultKind::kStuckAt, 0.0, kShoulder)).out[0].dac[0], at_rest);
}

TEST(FaultSites, TorqueGainAndCommandReachTheBoards) {
  EXPECT_EQ(Struck(now(FaultVariable::kCurrentCmd, FaultKind::kStuckAt, 1234, kShoulder)).out[0].dac[0], 1234);
  EXPECT_NE(Struck(now(FaultVariable::kTauD, FaultKind::kStuckAt, 0.5, kShoulder)).out[0].dac[0], 0);
  Struck loud(now(FaultVariable::kGain, FaultKind::kStuckAt, 0.0, -1));
  const auto push = [](Bench* bench) {
    for (int k = 0; k < 10; ++k) {
      bench->q[0][kShoulder] += 0.0005;
      bench->cycle();
    }
    bench->cycles(3);
  };
  push(&loud);
  const std::int16_t off = loud.out[0].dac[0];
  Bench clean;
  clean.bringTo(RunLevel::kPedalDown);
  push(&clean);
  EXPECT_GT(std::abs(clean.out[0].dac[0]), std::abs(off) + 100) << "without gains only gravity is left";
}

TEST(FaultSites, GainsAreRightAgainOnceTheFaultIsCleared) {
  Struck bench(now(FaultVariable::kGain, FaultKind::kStuckAt, 0.0, -1));
  FaultPlan nothing;
  nothing.generation = 1U << 30U;
  bench.software.setFaults(nothing);
  Bench clean;
  clean.bringTo(RunLevel::kPedalDown);
  clean.cycles(20);
  for (Bench* one : {static_cast<Bench*>(&bench), &clean}) {
    for (int k = 0; k < 10; ++k) {
      one->q[0][kShoulder] += 0.0005;
      one->cycle();
    }
    one->cycles(3);
  }
  EXPECT_EQ(bench.out[0].dac[0], clean.out[0].dac[0]);
}

TEST(FaultSites, ALevelBeyondTheLastIsTheLast) {
  EXPECT_EQ(Struck(now(FaultVariable::kRunLevelDesired, FaultKind::kAdd, 3)).level(), RunLevel::kPedalDown);
  EXPECT_EQ(Struck(now(FaultVariable::kRunLevelDesired, FaultKind::kSignFlip, 0)).level(), RunLevel::kEStop);
}

TEST(FaultSites, TheLargestNegativeCommandIsStoppedAsTheLargestPositiveOne) {
  for (const double value : {-1e6, 1e6}) {
    Fault fault = now(FaultVariable::kCurrentCmd, FaultKind::kAdd, value, kShoulder);
    Struck bench(fault);
    EXPECT_EQ(bench.software.state().soft_estopped, 1) << value;
  }
}

TEST(FaultSites, ACommandBeforeTheCheckIsSeenByItAndOneBehindIsNot) {
  Struck before(now(FaultVariable::kCurrentCmd, FaultKind::kStuckAt, 30000, kShoulder));
  EXPECT_EQ(before.software.state().soft_estopped, 1);
  EXPECT_EQ(before.out[0].dac[0], 0);
  Struck behind(now(FaultVariable::kDac, FaultKind::kStuckAt, 30000, kShoulder));
  EXPECT_EQ(behind.software.state().soft_estopped, 0);
  EXPECT_EQ(behind.out[0].dac[0], 30000);
}

TEST(FaultSites, OnlyTheLow16BitsOfACommandTravel) {
  EXPECT_EQ(Struck(now(FaultVariable::kDac, FaultKind::kStuckAt, 100000, kShoulder)).out[0].dac[0],
            static_cast<std::int16_t>(100000 - 2 * 65536));
}

TEST(FaultSites, PinsForThePlcAreWhatTheyAreToldToBe) {
  EXPECT_EQ(Struck(now(FaultVariable::kSurgeonMode, FaultKind::kStuckAt, 0)).out[0].pins & pins::kFootPedal, 0);
  EXPECT_EQ(Struck(now(FaultVariable::kRunLevel, FaultKind::kStuckAt, 1)).out[0].pins & pins::kLevelMask, 1);
  EXPECT_EQ(Struck(now(FaultVariable::kInitialized, FaultKind::kStuckAt, 0)).out[0].pins & pins::kReady, 0);
  EXPECT_EQ(Struck(now(FaultVariable::kOutputs, FaultKind::kStuckAt, 0x55)).out[0].pins, 0x55);
  EXPECT_NE(Struck(now(FaultVariable::kOutputs, FaultKind::kStuckAt, 0x55)).out[1].pins, 0x55) << "gold only";
}

TEST(FaultSites, ABoardThatIsNotWrittenKeepsItsLastCommand) {
  for (const Fault& fault : {now(FaultVariable::kPutBoardCount, FaultKind::kStuckAt, 0),
                             now(FaultVariable::kPutBoardIndex, FaultKind::kStuckAt, 2)}) {
    Struck bench(fault);
    const UsbOut before = bench.out[0];
    bench.q[0][kShoulder] += 0.01;
    for (int k = 0; k < 60; ++k) {
      bench.cycle();
      EXPECT_EQ(bench.out[0].dac, before.dac);
      ASSERT_EQ(bench.out[0].pins, before.pins) << "no watchdog either";
    }
  }
}

TEST(FaultSites, WritingMoreBoardsThanThereAreEndsTheProgram) {
  Struck bench(now(FaultVariable::kPutBoardCount, FaultKind::kStuckAt, 3));
  EXPECT_FALSE(bench.software.isAlive());
  EXPECT_EQ(bench.software.state().program, ProgramState::kCrashed);
  const std::uint64_t cycle = bench.software.state().cycle;
  const UsbOut last = bench.out[0];
  bench.cycles(10);
  EXPECT_EQ(bench.software.state().cycle, cycle);
  EXPECT_EQ(bench.out[0].dac, last.dac);
  RobotState state;
  bench.software.returnState(1);
  ASSERT_TRUE(bench.software.nextReturned(&state));
  EXPECT_EQ(state.fault_mask, 1) << "the fault that ended the program";
  bench.software.returnState(2);
  EXPECT_FALSE(bench.software.nextReturned(&state)) << "an ended program reports nothing more";
}

TEST(FaultSites, AProgramCanCrashOrHang) {
  EXPECT_EQ(Struck(now(FaultVariable::kProgram, FaultKind::kCrash, 0)).software.state().program,
            ProgramState::kCrashed);
  EXPECT_EQ(Struck(now(FaultVariable::kProgram, FaultKind::kHang, 0)).software.state().program, ProgramState::kHung);
}

TEST(FaultSites, TheReturnedStateIsWhatTheFaultMakesOfIt) {
  Struck bench(now(FaultVariable::kReturnedJpos, FaultKind::kStuckAt, 0.25, kElbow));
  bench.software.returnState(77);
  RobotState state;
  ASSERT_TRUE(bench.software.nextReturned(&state));
  EXPECT_EQ(state.arms[0].q[kElbow], 0.25);
  EXPECT_NE(bench.gold().q[kElbow], 0.25) << "the robot itself knows better";
  EXPECT_EQ(state.time_ns, 77);
  EXPECT_EQ(state.active_fault, 5U);
  EXPECT_EQ(state.fault_mask, 1);
  EXPECT_FALSE(bench.software.nextReturned(&state));
}

TEST(FaultSites, AFrozenStateKeepsItsNumbersAndNothingElse) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  const auto next = [&](std::int64_t time) {
    bench.cycle();
    bench.software.returnState(time);
    RobotState state;
    EXPECT_TRUE(bench.software.nextReturned(&state));
    return state;
  };
  const RobotState before = next(1);
  arm(&bench, now(FaultVariable::kFrame, FaultKind::kHoldLast, 0));
  bench.q[0][kShoulder] += 0.1;
  const RobotState frozen = next(2);
  EXPECT_EQ(frozen.arms[0].q, before.arms[0].q);
  EXPECT_EQ(frozen.cycle, before.cycle + 1);
  EXPECT_EQ(frozen.time_ns, 2);
}

TEST(FaultSites, AFrozenStateSaysThatItIs) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  RobotState state;
  for (int k = 0; k < 3; ++k) {
    bench.cycle();
    bench.software.returnState(k);
    ASSERT_TRUE(bench.software.nextReturned(&state));
  }
  EXPECT_EQ(state.fault_mask, 0);
  arm(&bench, now(FaultVariable::kFrame, FaultKind::kHoldLast, 0));
  bench.cycle();
  bench.software.returnState(3);
  ASSERT_TRUE(bench.software.nextReturned(&state));
  EXPECT_EQ(state.fault_mask, 1) << "the record must know what was injected";
  EXPECT_EQ(state.active_fault, 5U);
}

TEST(FaultSites, AFrozenPacketRepeatsTheMotionBeforeItUnderItsOwnNumber) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  const auto sendGold = [&](std::int32_t um) {
    const std::int32_t before = bench.software.report().pos_d_um[2];
    wire::ItpPacket packet = bench.next();
    packet.dely_um[0] = um;  // base z
    EXPECT_EQ(bench.send(packet), Reject::kNone);
    bench.cycle();
    return bench.software.report().pos_d_um[2] - before;
  };
  EXPECT_EQ(sendGold(30), 30);
  Fault frozen = now(FaultVariable::kPacket, FaultKind::kHoldLast, 0);
  frozen.arm = -1;
  arm(&bench, frozen);
  bench.cycle();
  for (int k = 0; k < 5; ++k)
    EXPECT_EQ(sendGold(7), 30) << k;
}

/** The true packets have the pedal up. In the base frame gold goes along (-z, -x, y), green along (-z, x, -y). */
TEST(FaultSites, AForgedPacketMovesItsArmAlongItsAxisWithThePedalDown) {
  const PerArm<std::array<int, 3>> base_axis{{{1, 2, 0}, {1, 2, 0}}}, sign{{{-1, 1, -1}, {1, -1, -1}}};
  for (const Arm which : kArms) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Bench bench;
      bench.bringTo(RunLevel::kPedalDown);
      Fault forged = now(FaultVariable::kPacket, FaultKind::kForge, 3000, static_cast<int>(axis));
      forged.arm = static_cast<std::int8_t>(index(which));
      forged.low = 1.0;  // numbered as the next true packet
      arm(&bench, forged);
      bench.cycle();
      std::array<std::int32_t, 6> expected = bench.software.report().pos_d_um;
      expected[3 * index(which) + static_cast<std::size_t>(at(base_axis, which)[axis])] += 3000 * at(sign, which)[axis];
      wire::ItpPacket packet = bench.next();
      packet.surgeon_mode = 0;
      bench.send(packet);
      EXPECT_NE(bench.cycle().pins & pins::kFootPedal, 0) << name(which) << " " << axis;
      EXPECT_EQ(bench.software.report().pos_d_um, expected) << name(which) << " " << axis;
      EXPECT_EQ(bench.software.state().last_sequence, packet.sequence + 1);
    }
  }
}

TEST(FaultSites, PacketsCanBeHeldBackAndCountWhenTheyCome) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  Fault late = now(FaultVariable::kPacket, FaultKind::kDelay, 0);
  late.arm = -1;
  late.low = late.high = 5;
  arm(&bench, late);
  bench.cycle();
  const std::uint64_t received = bench.software.state().itp.received;
  bench.send();
  bench.cycles(4);
  EXPECT_EQ(bench.software.state().itp.received, received);
  bench.cycles(2);
  EXPECT_EQ(bench.software.state().itp.received, received + 1);
  EXPECT_TRUE(bench.software.state().itp.addsUp());
}

TEST(FaultSites, TheReturnedRunLevelIsWhatTheFaultMakesOfItAndNoOther) {
  for (const int level : {0, 1, 2}) {
    Struck bench(now(FaultVariable::kReturnedRunLevel, FaultKind::kStuckAt, level));
    bench.software.returnState(77);
    RobotState state;
    ASSERT_TRUE(bench.software.nextReturned(&state));
    EXPECT_EQ(static_cast<int>(state.runlevel), level);
    EXPECT_EQ(bench.level(), RunLevel::kPedalDown) << "the robot itself knows better";
  }
}

TEST(FaultSites, AFrozenPacketRepeatsThePedalToo) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  bench.send();
  Fault frozen = now(FaultVariable::kPacket, FaultKind::kHoldLast, 0);
  frozen.arm = -1;
  arm(&bench, frozen);
  bench.cycle();
  for (int k = 0; k < 5; ++k) {
    wire::ItpPacket released = bench.next();
    released.surgeon_mode = 0;
    EXPECT_EQ(bench.send(released), Reject::kNone);
    EXPECT_NE(bench.cycle().pins & pins::kFootPedal, 0) << k;
  }
}

}  // namespace
}  // namespace raven2_trainer::raven
