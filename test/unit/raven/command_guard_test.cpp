#include "raven/command_guard.h"

#include <gtest/gtest.h>

#include "raven2_trainer/raven/drives.h"
#include "unit/raven/raven_fixture.h"

// Mitigation by the detector: `hold` replaces the command of the arm that raised the alarm, `stop` zeroes both arms.

namespace raven2_trainer::raven {
namespace {

using test::Bench;
using test::quickHoming;
using test::trainerConfig;

constexpr std::int32_t kThrow = 12000;  // [counts] beyond the clip, below the overdrive limit

/** Rule `published`, a tenth of the thresholds: the first command that throws an arm raises the alarm. */
DetectorConfig alert(Mitigation mitigate) {
  DetectorConfig config = trainerConfig().detector;
  config.rule = DetectorRule::kPublished;
  config.factor = 0.1;
  config.excursion = 0.0;
  config.mitigate = mitigate;
  return config;
}

class Guarded : public ::testing::TestWithParam<Arm> {
 protected:
  /** One cycle, a different calm command for each arm. @param[in] thrown on the tested arm's shoulder, unless 0.
   *  @param[in] others on the other arm's. */
  bool check(CommandGuard* guard, std::int32_t thrown = 0, std::int32_t others = 0) {
    PerArm<CommandGuard::ArmCommand> commands;
    for (const Arm arm : kArms) {
      at(dac_, arm) = calm(arm);
      if (thrown != 0 && arm == GetParam()) at(dac_, arm)[kShoulder] = thrown;
      if (others != 0 && arm != GetParam()) at(dac_, arm)[kShoulder] = others;
      UsbOut out;
      out.pins = 0x1F;
      for (std::size_t j = 0; j < kJointCount; ++j)
        out.dac[channelOf(j)] = static_cast<std::int16_t>(at(dac_, arm)[j]);
      at(packets_, arm) = encodeOut(out);
      at(commands, arm) = {&motor_, &q_, &at(dac_, arm), &at(packets_, arm)};
    }
    return guard->check(commands, /*engaged=*/true, /*soft_estopped=*/false);
  }

  /** Counts that about balance the identified load (config/detector.yaml) at home. */
  static DacArray calm(Arm arm) {
    return arm == Arm::kGold ? DacArray{40, 159, -44, 1, 2, 3, 4} : DacArray{-45, -150, 50, 5, 6, 7, 8};
  }
  /** The packet that the arm's board gets. */
  UsbOut written(Arm arm) const {
    UsbOut out;
    EXPECT_TRUE(decodeOut(at(packets_, arm), &out));
    return out;
  }
  void expectWritten(Arm arm, const DacArray& expected) const {
    EXPECT_EQ(at(dac_, arm), expected) << name(arm);
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_EQ(written(arm).dac[channelOf(j)], expected[j]) << name(arm) << " " << kJointNames[j];
    EXPECT_EQ(written(arm).pins, 0x1F);
  }

  const JointArray q_ = trainerConfig().arms.geometry.home;
  const JointArray motor_ = CableCoupling(Arm::kGold, trainerConfig().virtual_raven).toMotor(q_);
  PerArm<DacArray> dac_{};
  PerArm<UsbOutBytes> packets_{};
};

TEST_P(Guarded, HoldWritesTheArmsOwnLastSafeCommandAndLeavesTheOtherArm) {
  for (const std::int32_t thrown : {-kThrow, kThrow}) {
    CommandGuard guard(trainerConfig().arms, trainerConfig().virtual_raven, alert(Mitigation::kHold));
    for (int k = 0; k < 10; ++k) {
      ASSERT_FALSE(check(&guard));
      ASSERT_FALSE(guard.report().verdict.alarm) << "the calm commands must raise no alarm";
    }
    EXPECT_FALSE(check(&guard, thrown));
    ASSERT_TRUE(guard.report().verdict.alarm);
    EXPECT_EQ(guard.report().verdict.arm, GetParam());
    for (const Arm arm : kArms)
      expectWritten(arm, calm(arm));
  }
}

/** One of them is nearer to an alarm; the other one is as unsafe. */
TEST_P(Guarded, HoldWritesTheLastSafeCommandsOfBothArmsWhenBothAreThrown) {
  for (const std::int32_t others : {-kThrow, kThrow}) {
    CommandGuard guard(trainerConfig().arms, trainerConfig().virtual_raven, alert(Mitigation::kHold));
    for (int k = 0; k < 10; ++k)
      check(&guard);
    check(&guard, kThrow, others);
    ASSERT_TRUE(guard.report().verdict.alarm);
    for (const Arm arm : kArms)
      expectWritten(arm, calm(arm));
    EXPECT_EQ(guard.report().alarms, 1U);
    EXPECT_EQ(guard.report().cycles_acted, 1U);
  }
}

/** The guard must not fall back to a command beyond the clip, even if the command raised no alarm. */
TEST_P(Guarded, HoldNeverWritesACommandFromBeyondTheClip) {
  DetectorConfig config = alert(Mitigation::kHold);
  config.factor = 0.12;  // 2600 counts, a hundred beyond the clip, are a third of it and kThrow more than it
  for (const std::int32_t sign : {-1, 1}) {
    CommandGuard guard(trainerConfig().arms, trainerConfig().virtual_raven, config);
    for (int k = 0; k < 10; ++k)
      check(&guard);
    check(&guard, sign * 2600);
    ASSERT_FALSE(guard.report().verdict.alarm);
    ASSERT_LT(guard.report().verdict.size, 0.5 * config.factor) << "only the clip distinguishes it from a calm command";
    check(&guard, sign * kThrow);
    ASSERT_TRUE(guard.report().verdict.alarm);
    expectWritten(GetParam(), calm(GetParam()));
  }
}

/** With a small factor an alarm is small, too: the command that raises it is no safe one. */
TEST_P(Guarded, HoldNeverWritesTheCommandThatRaisedTheAlarm) {
  DetectorConfig config = alert(Mitigation::kHold);
  config.factor = 0.03;  // 2400 counts, within the clip, are a little more than it
  for (const std::int32_t sign : {-1, 1}) {
    CommandGuard guard(trainerConfig().arms, trainerConfig().virtual_raven, config);
    for (int k = 0; k < 10; ++k)
      check(&guard);
    ASSERT_FALSE(guard.report().verdict.alarm);
    check(&guard, sign * 2400);
    ASSERT_TRUE(guard.report().verdict.alarm);
    ASSERT_LT(guard.report().verdict.size, 0.5);
    for (int k = 0; k < 2; ++k) {
      expectWritten(GetParam(), calm(GetParam()));
      check(&guard, sign * 2400);
    }
  }
}

TEST_P(Guarded, StopZeroesBothArms) {
  CommandGuard guard(trainerConfig().arms, trainerConfig().virtual_raven, alert(Mitigation::kStop));
  for (int k = 0; k < 10; ++k)
    ASSERT_FALSE(check(&guard));
  EXPECT_TRUE(check(&guard, kThrow));
  for (const Arm arm : kArms)
    expectWritten(arm, DacArray{});
}

TEST_P(Guarded, CountsEachAlarmOnceAndEachCycleThatItActed) {
  CommandGuard guard(trainerConfig().arms, trainerConfig().virtual_raven, alert(Mitigation::kHold));
  for (std::uint64_t alarm = 1; alarm <= 3; ++alarm) {
    for (int k = 0; k < 5; ++k)
      check(&guard);
    for (int k = 0; k < 4; ++k)
      check(&guard, kThrow);
    EXPECT_EQ(guard.report().alarms, alarm);
    EXPECT_EQ(guard.report().cycles_acted, 4 * alarm);
  }
}

/** An engaged robot with a guard. */
void engageGuarded(Mitigation mitigate, Bench* bench) {
  bench->software.setDetector(alert(mitigate));
  bench->software.startAtHome();
  bench->plc = RunLevel::kPedalUp;
  bench->cycles(5);
  bench->engage();
  ASSERT_EQ(bench->software.detectorReport().alarms, 0U);
}

/** put_USB_packet writes kThrow to the arm's shoulder, until it is cleared. */
FaultPlan throwing(Arm arm) {
  FaultPlan plan;
  plan.generation = plan.session = plan.count = 1;
  Fault& fault = plan.faults[0];
  fault.id = 1;
  fault.site = FaultSite::kPutUsbPacket;
  fault.variable = FaultVariable::kDac;
  fault.kind = FaultKind::kStuckAt;
  fault.trigger = FaultTrigger::kHand;
  fault.arm = static_cast<std::int8_t>(index(arm));
  fault.channel = kShoulder;
  fault.value = kThrow;
  return plan;
}

TEST_P(Guarded, ActsOnFaultsOfTheControlProgramOnEitherArm) {
  for (const Mitigation mitigate : {Mitigation::kHold, Mitigation::kStop}) {
    Bench bench;
    engageGuarded(mitigate, &bench);
    bench.software.setFaults(throwing(GetParam()));
    bench.cycle();
    EXPECT_EQ(bench.software.detectorReport().alarms, 1U);
    EXPECT_EQ(bench.software.detectorReport().verdict.arm, GetParam());
    EXPECT_LT(std::abs(at(bench.out, GetParam()).dac[kShoulder]), 500);
    EXPECT_EQ(bench.software.state().soft_estopped, mitigate == Mitigation::kStop ? 1 : 0);
  }
}

TEST_P(Guarded, StopKeepsBothBoardsAtZeroThoughTheFaultGoesOn) {
  Bench bench;
  engageGuarded(Mitigation::kStop, &bench);
  bench.software.setFaults(throwing(GetParam()));
  for (int k = 0; k < 100; ++k) {  // the PLC takes 200 cycles to miss the watchdog
    bench.cycle();
    ASSERT_EQ(bench.software.state().soft_estopped, 1) << k;
    for (const UsbOut& out : bench.out)
      ASSERT_EQ(out.dac, (std::array<std::int16_t, kChannels>{})) << k;
  }
  EXPECT_EQ(bench.software.detectorReport().alarms, 1U);
  EXPECT_EQ(bench.software.detectorReport().cycles_acted, 100U);
}

TEST_P(Guarded, ALaterStopWithoutAnAlarmIsNotTheGuards) {
  CommandGuard guard(trainerConfig().arms, trainerConfig().virtual_raven, alert(Mitigation::kStop));
  for (int k = 0; k < 10; ++k)
    ASSERT_FALSE(check(&guard));
  ASSERT_TRUE(check(&guard, kThrow));
  ASSERT_FALSE(check(&guard)) << "the E-stop was cleared";
  for (const Arm arm : kArms)
    expectWritten(arm, calm(arm));
}

TEST_P(Guarded, DrivesHaveThePublishedScaleAndSignOfTheArm) {
  // raven2.md 3.1: 3695.807 counts per capstan Nm, gold's positioning joints turn against the command.
  const detector::Drives drives = drivesOf(trainerConfig().arms, trainerConfig().virtual_raven);
  for (std::size_t j = 0; j < detector::kAxes; ++j) {
    const double sign = GetParam() == Arm::kGold ? -1.0 : 1.0;
    EXPECT_NEAR(at(drives.torque_per_count, GetParam())[j], sign / 3695.807, 1e-9);
  }
  EXPECT_EQ(drives.position_gain, (Vec3{0.30, 0.30, 0.15}));  // raven2.md 3.4
  EXPECT_EQ(drives.clip, (Vec3{2500.0, 2500.0, 2000.0}));
}

INSTANTIATE_TEST_SUITE_P(Arms, Guarded, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

}  // namespace
}  // namespace raven2_trainer::raven
