#include "raven2_trainer/raven/control_software.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "unit/raven/raven_fixture.h"

namespace raven2_trainer::raven {
namespace {

using test::Bench;
using test::trainerConfig;

FaultPlan planOf(FaultVariable variable, FaultKind kind, double value, std::int8_t channel = kShoulder) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  Fault& fault = plan.faults[0];
  fault.id = 9;
  fault.site = infoOf(variable).site;
  fault.variable = variable;
  fault.kind = kind;
  fault.arm = 0;
  fault.channel = channel;
  fault.duration_ticks = 5;
  fault.value = value;
  return plan;
}

TEST(ControlSoftware, RefusesABehaviourThatDoesNotExist) {
  VirtualRavenConfig config = trainerConfig().virtual_raven;
  config.behaviour = "meteor";
  EXPECT_THROW(ControlSoftware(trainerConfig().arms, config), ConfigException);
}

TEST(ControlSoftware, HomesOnceThenReachesPedalDown) {
  Bench bench;
  bench.cycles(50);
  EXPECT_EQ(bench.level(), RunLevel::kEStop);
  bench.bringTo(RunLevel::kPedalDown);
  EXPECT_EQ(bench.level(), RunLevel::kPedalDown);
  EXPECT_EQ(bench.software.state().homed, 1);
  EXPECT_EQ(bench.software.state().is_virtual, 1);
}

TEST(ControlSoftware, AfterALaterEStopReadyComesWithoutHoming) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalUp);
  bench.plc = RunLevel::kEStop;
  bench.cycles(10);
  bench.plc = RunLevel::kInit;
  int cycles = 0;
  while ((bench.cycle().pins & pins::kReady) == 0 && cycles < 100)
    ++cycles;
  EXPECT_LE(cycles, 4 + 14);  // 3 cycles for the level, about 14 for the sub-levels (raven2.md 4.3)
}

TEST(ControlSoftware, PublishesTheJointsThatTheEncodersShow) {
  Bench bench;
  at(bench.q, Arm::kGold)[kShoulder] = 0.6;
  at(bench.q, Arm::kGreen)[kWrist] = -0.3;
  bench.cycles(5);
  const RobotState& state = bench.software.state();
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_NEAR(at(state.arms, arm).q[j], at(bench.q, arm)[j], 1e-3) << name(arm) << " " << kJointNames[j];
    }
  }
}

TEST(ControlSoftware, PublishedVelocityIsSmoothAndUnbiased) {
  Bench bench;
  constexpr double kRate = 0.05;  // [rad/s] 6.8 rad/s of the motor: 4.3 quanta
  double sum = 0.0, worst = 0.0;
  for (int k = 0; k < 1000; ++k) {
    at(bench.q, Arm::kGold)[kShoulder] += kRate * kTickSeconds;
    bench.cycle();
    if (k < 100) continue;
    const double dq = at(bench.software.state().arms, Arm::kGold).dq[kShoulder];
    sum += dq;
    worst = std::max(worst, std::abs(dq - kRate));
  }
  EXPECT_NEAR(sum / 900, kRate, 1e-4);
  EXPECT_LT(worst, 0.5 * 1.571 / 136.2);  // half a quantum of the raw difference
}

TEST(ControlSoftware, TargetFollowsThePacketsInPedalDownOnly) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalUp);
  wire::ItpPacket packet = bench.next();
  packet.dely_um[0] = 3000;
  bench.send(packet);
  bench.plc = RunLevel::kPedalDown;
  bench.cycles(20);
  // The motion in the packet that presses the pedal is lost, so only gravity is commanded.
  EXPECT_NEAR(at(bench.software.state().arms, Arm::kGold).dac[kShoulder], 45, 3);
  packet = bench.next();
  packet.dely_um[0] = 3000;
  bench.send(packet);
  bench.cycle();
  EXPECT_GT(std::abs(at(bench.software.state().arms, Arm::kGold).dac[kInsertion] + 44) +
                std::abs(at(bench.software.state().arms, Arm::kGold).dac[kShoulder] - 45),
            100);
}

TEST(ControlSoftware, OnlyGravityIsCommandedWithThePedalUp) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalUp);
  const auto& dac = at(bench.software.state().arms, Arm::kGold).dac;
  EXPECT_NEAR(dac[kShoulder], 45, 1);
  EXPECT_NEAR(dac[kElbow], 159, 1);
  EXPECT_NEAR(dac[kInsertion], -44, 1);
  for (std::size_t j = kToolRotation; j < kJointCount; ++j)
    EXPECT_EQ(dac[j], 0);
}

TEST(ControlSoftware, AnyNonZeroSurgeonModeEngages) {
  for (const std::int32_t mode : {1, 2, -1, 256}) {
    Bench bench;
    bench.bringTo(RunLevel::kPedalUp);
    wire::ItpPacket packet = bench.next();
    packet.surgeon_mode = mode;
    bench.send(packet);
    EXPECT_NE(bench.cycle().pins & pins::kFootPedal, 0) << mode;
  }
}

TEST(ControlSoftware, MasterSilenceLiftsThePedalAfterTheTimeOut) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  bench.send();
  for (int k = 0; k <= 5000; ++k)  // the cycle that sees the packet, and 5000 silent ones
    EXPECT_NE(bench.cycle().pins & pins::kFootPedal, 0) << k;
  EXPECT_EQ(bench.cycle().pins & pins::kFootPedal, 0);
}

TEST(ControlSoftware, AutomovesKeepThePedalDownAsPacketsDo) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  for (int k = 0; k < 3; ++k) {
    for (int silent = 0; silent < 4000; ++silent)
      ASSERT_NE(bench.cycle().pins & pins::kFootPedal, 0) << k;
    bench.software.automove({}, {kIdentityQuat, kIdentityQuat});
  }
  bench.cycles(5001);  // the cycle that sees the last one, and 5000 without any
  EXPECT_EQ(bench.cycle().pins & pins::kFootPedal, 0);
}

TEST(ControlSoftware, DuplicatesDoNotKeepTheTimeOutAlive) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  const wire::ItpPacket packet = bench.next();
  bench.send(packet);
  for (int k = 0; k <= 5000; ++k) {
    EXPECT_EQ(bench.send(packet), Reject::kDuplicate);
    bench.cycle();
  }
  EXPECT_EQ(bench.cycle().pins & pins::kFootPedal, 0);
}

TEST(ControlSoftware, LongDatagramsAreCutAndShortOnesRejected) {
  Bench bench;
  std::array<std::uint8_t, 134> bytes{};
  const wire::ItpBytes packet = wire::encodeItp(bench.next());
  std::copy(packet.begin(), packet.end(), bytes.begin());
  bench.software.receive(bytes.data(), bytes.size());
  EXPECT_EQ(bench.software.state().itp.applied, 1u);
  bench.software.receive(bytes.data(), 123);
  bench.software.receive(bytes.data(), 0);
  EXPECT_EQ(bench.software.state().itp.rejected[static_cast<std::size_t>(Reject::kWrongSize)], 2u);
}

TEST(ControlSoftware, ChecksumIsNotChecked) {
  Bench bench;
  wire::ItpPacket packet = bench.next();
  packet.checksum = 12345;
  EXPECT_EQ(bench.send(packet), Reject::kNone);
}

TEST(ControlSoftware, CountersAddUpUnderRandomPackets) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  Random random(11);
  std::vector<std::uint8_t> bytes(200);
  for (int n = 0; n < 5000; ++n) {
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random.next());
    const std::uint32_t kind = random.next() % 4;
    wire::ItpPacket packet = bench.next();
    if (kind == 1) packet.sequence = random.next() % 3000;
    if (kind == 2) packet.Qw[0] = 0.0;
    const wire::ItpBytes good = wire::encodeItp(packet);
    if (kind != 0) std::copy(good.begin(), good.end(), bytes.begin());
    bench.software.receive(bytes.data(), random.next() % 8 == 0 ? random.next() % 200 : wire::kItpSize);
    if (n % 10 == 0) bench.cycle();
  }
  const LinkCounts& counts = bench.software.state().itp;
  EXPECT_TRUE(counts.addsUp());
  EXPECT_EQ(counts.received, 5001u);
  EXPECT_GT(counts.applied, 100u);
  EXPECT_GT(counts.rejectedTotal(), 1000u);
  for (const Arm arm : kArms) {
    for (const double q : at(bench.software.state().arms, arm).q)
      EXPECT_TRUE(std::isfinite(q));
  }
}

TEST(ControlSoftware, QuaternionsAreNotJudged) {
  Bench bench;
  wire::ItpPacket packet = bench.next();
  packet.Qw[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(bench.send(packet), Reject::kNone);
  packet = bench.next();
  packet.Qw[0] = 0.0;
  EXPECT_EQ(bench.send(packet), Reject::kNone);
}

std::int32_t dacOf(const Bench& bench, Arm arm, Joint joint) {
  return at(bench.software.state().arms, arm).dac[joint];
}

TEST(ControlSoftware, ARefusedGoldTargetFreezesGreenToo) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  const std::int32_t before = dacOf(bench, Arm::kGreen, kShoulder);
  wire::ItpPacket packet = bench.next();
  packet.dely_um[0] = 300000;  // nowhere near
  packet.delx_um[1] = 2000;
  bench.send(packet);
  bench.cycles(3);
  EXPECT_EQ(bench.level(), RunLevel::kPedalDown);  // silently
  EXPECT_EQ(dacOf(bench, Arm::kGreen, kShoulder), before);
}

TEST(ControlSoftware, ARefusedGreenTargetDoesNotFreezeGold) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  const std::int32_t green = dacOf(bench, Arm::kGreen, kShoulder);
  const std::int32_t gold = dacOf(bench, Arm::kGold, kShoulder);
  wire::ItpPacket packet = bench.next();
  packet.delx_um[0] = 2000;
  packet.dely_um[1] = 300000;
  bench.send(packet);
  bench.cycles(3);
  EXPECT_EQ(dacOf(bench, Arm::kGreen, kShoulder), green);
  EXPECT_GT(std::abs(dacOf(bench, Arm::kGold, kShoulder) - gold), 100);
}

TEST(ControlSoftware, TheMasterCannotWindUpPastAJointLimit) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalUp);
  for (JointArray& q : bench.q)
    q[kShoulder] = 0.004;  // limit at 0
  bench.cycles(5);
  bench.engage();
  const kinematics::Jacobian J = kinematics::jacobian(bench.arms.geometry, Arm::kGold, at(bench.q, Arm::kGold));
  const Vector3 along = -J.block<3, 1>(0, kShoulder).normalized();  // towards the limit, base frame
  // base -> ITP of gold: x = -y_B, y = z_B, z = -x_B
  const auto send = [&](double um) {
    wire::ItpPacket packet = bench.next();
    packet.delx_um[0] = static_cast<std::int32_t>(-along.y() * um);
    packet.dely_um[0] = static_cast<std::int32_t>(along.z() * um);
    packet.delz_um[0] = static_cast<std::int32_t>(-along.x() * um);
    bench.send(packet);
    bench.cycle();
  };
  for (int k = 0; k < 20; ++k)
    send(500);  // 10 mm past a limit 0.4 mm away
  const double at_limit = dacOf(bench, Arm::kGold, kShoulder);
  send(-500);
  const double way_back = dacOf(bench, Arm::kGold, kShoulder);
  // Gold's shoulder torque is negative for positive DAC: the demand must change direction with the first packet back.
  EXPECT_LT(way_back, at_limit - 500);
}

TEST(ControlSoftware, AnOverdriveRowGivesZeroThenSoftEStopAndNoWatchdog) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  for (int step = 0; step < 8; ++step) {  // 16 mm in 8 packets: each within reach of the inverse, together 9 degrees
    wire::ItpPacket packet = bench.next();
    packet.delx_um[0] = 2000;
    bench.send(packet);
  }
  bench.cycle();
  EXPECT_EQ(bench.software.state().soft_estopped, 1);
  EXPECT_EQ(dacOf(bench, Arm::kGold, kShoulder), 0);
  bench.cycle();
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_EQ(at(bench.software.state().arms, Arm::kGreen).dac[j], 0);
  EXPECT_EQ(bench.level(), RunLevel::kPedalDown);  // the PLC decides, when it misses the watchdog
  for (int k = 0; k < 60; ++k)
    EXPECT_EQ(bench.cycle().pins & pins::kWatchdog, 0);
  bench.plc = RunLevel::kEStop;
  bench.cycles(5);
  EXPECT_EQ(bench.software.state().soft_estopped, 0);
}

TEST(ControlSoftware, DacFaultsActBehindTheSafetyChecks) {
  Bench bench;
  bench.software.setFaults(planOf(FaultVariable::kDac, FaultKind::kStuckAt, 30000));
  bench.bringTo(RunLevel::kPedalUp);
  bench.send();
  bench.plc = RunLevel::kPedalDown;
  int faulted = 0;
  for (int k = 0; k < 30; ++k) {
    const UsbOut out = bench.cycle();
    const bool active = bench.software.state().active_fault == 9;
    EXPECT_EQ(out.dac[kShoulder] == 30000, active);  // neither clipped nor noticed
    faulted += active ? 1 : 0;
  }
  EXPECT_EQ(faulted, 5);
  EXPECT_EQ(bench.software.state().soft_estopped, 0);
}

TEST(ControlSoftware, EncoderFaultsActBeforeTheStateIsEstimated) {
  Bench bench;
  bench.software.setFaults(planOf(FaultVariable::kEncoder, FaultKind::kAdd, 1000));
  bench.bringTo(RunLevel::kPedalUp);
  const double before = at(bench.software.state().arms, Arm::kGold).motor[kShoulder];
  bench.send();
  bench.plc = RunLevel::kPedalDown;
  double largest = 0.0;
  for (int k = 0; k < 30; ++k) {
    bench.cycle();
    largest = std::max(largest, std::abs(at(bench.software.state().arms, Arm::kGold).motor[kShoulder] - before));
  }
  EXPECT_NEAR(largest, 1000 * 2 * kPi / 4000, 1e-9);
}

TEST(ControlSoftware, NetworkFaultsActOnTheFieldsBeforeTheyAreUsed) {
  Bench bench;
  FaultPlan plan = planOf(FaultVariable::kPedal, FaultKind::kStuckAt, 0, -1);
  plan.faults[0].arm = -1;
  plan.faults[0].duration_ticks = 1000;
  bench.software.setFaults(plan);
  bench.bringTo(RunLevel::kPedalDown);
  EXPECT_NE(bench.cycle().pins & pins::kFootPedal, 0);
  bench.send();  // pedal pressed on the wire
  EXPECT_EQ(bench.cycle().pins & pins::kFootPedal, 0);
}

TEST(ControlSoftware, InTheInitAfterAnEmergencyStopTheTargetFollowsTheRobot) {
  Bench bench;
  bench.software.startAtHome();
  bench.plc = RunLevel::kPedalUp;
  bench.cycles(5);
  bench.engage();
  bench.plc = RunLevel::kEStop;
  bench.cycles(10);
  bench.plc = RunLevel::kInit;
  bench.cycles(5);
  for (int k = 0; k < 8; ++k) {  // brakes off, not READY yet: the arms sag
    for (JointArray& q : bench.q)
      q[kElbow] += 0.001;
    bench.cycle();
    ASSERT_EQ(bench.level(), RunLevel::kInit);
    EXPECT_EQ(bench.software.report().pos_d_um, bench.software.report().pos_um) << k;
  }
}

TEST(ControlSoftware, FollowingTheRobotCountsAsAnUpdateForTheTimeOut) {
  Bench bench;
  bench.software.startAtHome();
  bench.plc = RunLevel::kPedalUp;  // the PLC does not answer the pedal
  bench.cycles(5);
  bench.send();
  for (int k = 0; k < 5100; ++k)
    ASSERT_NE(bench.cycle().pins & pins::kFootPedal, 0) << k;
}

TEST(ControlSoftware, TheReportHasTheSoftwaresUnitsAndSigns) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalUp);
  for (int k = 0; k < 20; ++k) {
    for (JointArray& q : bench.q) {
      for (std::size_t j = kShoulder; j <= kWrist; ++j)
        q[j] += (j == kInsertion ? 2e-5 : 2e-4) * (&q == &bench.q[0] ? 1.0 : -1.0);
    }
    bench.cycle();
  }
  const RavenReport& report = bench.software.report();
  for (const Arm arm : kArms) {
    const JointArray moved = at(bench.couplings, arm).toMotor(at(bench.q, arm));
    const JointArray power_on = at(bench.couplings, arm).toMotor(bench.arms.geometry.home);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const std::size_t k = index(arm) * kChannels + channelOf(j);
      const double counts = encoderSign(arm, j) * (moved[j] - power_on[j]) * 4000 / (2 * kPi);
      EXPECT_NEAR(report.encoder[k], -counts, 0.51) << "after its negation";
      // raven2.md 2.6: motor rate over the transmission for the first three joints, none for the tool's
      const double ratio = trainerConfig().virtual_raven.axes[j].transmission;
      EXPECT_NEAR(report.jvel[k], j <= kInsertion ? report.mvel[k] / ratio : 0.0, 1e-12) << kJointNames[j];
    }
    EXPECT_GT(std::abs(report.mvel[index(arm) * kChannels]), 1.0);
    for (const std::uint8_t joint : at(bench.software.state().arms, arm).jstate)
      EXPECT_EQ(joint, 4) << "ready (raven2.md 4.4)";
  }
}

TEST(ControlSoftware, AFaultsBeginningAndEndHaveTheirCycles) {
  Bench bench;
  bench.software.setFaults(planOf(FaultVariable::kDac, FaultKind::kStuckAt, 100));
  bench.bringTo(RunLevel::kPedalUp);
  bench.send();
  bench.plc = RunLevel::kPedalDown;
  int changes = 0;
  for (int k = 0; k < 30; ++k) {
    const bool was_active = bench.software.state().fault_mask != 0;
    bench.cycle();
    const bool is_active = bench.software.state().fault_mask != 0;
    FaultChange change;
    ASSERT_EQ(bench.software.nextFaultChange(&change), is_active != was_active);
    if (is_active == was_active) continue;
    EXPECT_EQ(change.cycle, bench.software.state().cycle);
    EXPECT_EQ(change.acts, is_active ? 1 : 0);
    ++changes;
  }
  EXPECT_EQ(changes, 2);
}

TEST(ControlSoftware, LastSequenceIsTheNetworkLayersLast) {
  Bench bench;
  bench.sequence = 40;
  bench.send();  // 41: a gap, dropped, but remembered
  bench.cycle();
  EXPECT_EQ(bench.software.state().last_sequence, 41u);
  EXPECT_EQ(bench.software.state().itp.applied, 0u);
}

TEST(ControlSoftware, TheMotorsGoThroughTheLowPassIfTheConfigurationSaysSo) {
  for (const bool low_pass : {false, true}) {
    VirtualRavenConfig config = test::quickHoming();
    config.low_pass = low_pass;
    Bench bench(config);
    bench.cycles(50);
    const auto motor = [&](Arm arm) { return at(bench.software.state().arms, arm).motor[kShoulder]; };
    const PerArm<double> before{motor(Arm::kGold), motor(Arm::kGreen)};
    for (JointArray& q : bench.q)
      q[kShoulder] += 0.01;
    bench.cycle();
    const double way = 0.01 * trainerConfig().virtual_raven.axes[kShoulder].transmission;
    for (const Arm arm : kArms)  // raven2.md 3.7: the newest value counts 0.02864
      EXPECT_NEAR((motor(arm) - at(before, arm)) / way, low_pass ? 0.02864 : 1.0, 0.002) << name(arm);
  }
}

TEST(ControlSoftware, WithoutGravityCompensationNothingIsCommandedWithThePedalUp) {
  VirtualRavenConfig config = test::quickHoming();
  config.gravity_compensation = false;
  Bench bench(config);
  bench.bringTo(RunLevel::kPedalUp);
  ASSERT_EQ(bench.level(), RunLevel::kPedalUp);
  for (const UsbOut& out : bench.out)
    EXPECT_EQ(out.dac, (std::array<std::int16_t, kChannels>{}));
}

TEST(ControlSoftware, EncoderOffsetsAreTheCountsOfEachMotorsZero) {
  // raven2.md 3.4: mpos = 2 pi / 4000 (count - offset); at power-on the counts are 0
  Bench bench;
  bench.cycles(5);
  for (const Arm arm : kArms) {
    const JointArray motor = at(bench.couplings, arm).toMotor(bench.arms.geometry.home);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const auto offset = bench.software.report().encoder_offset[index(arm) * kChannels + channelOf(j)];
      EXPECT_NEAR(static_cast<double>(offset), -motor[j] * 4000 / (2 * kPi), 0.1) << name(arm) << " " << kJointNames[j];
    }
  }
}

TEST(ControlSoftware, TheReportHasDesiredAndMeasuredMotorAnglesAndTorques) {
  Bench bench;
  bench.bringTo(RunLevel::kPedalDown);
  for (int k = 0; k < 20; ++k) {
    wire::ItpPacket packet = bench.next();
    packet.delx_um = packet.dely_um = packet.delz_um = {50, -50};
    bench.send(packet);
    bench.cycle();  // the arms rest
  }
  const RavenReport& report = bench.software.report();
  for (const Arm arm : kArms) {
    const std::size_t k = index(arm) * kChannels + channelOf(kInsertion);
    EXPECT_GT(std::abs(report.mpos_d[k] - report.mpos[k]), 1e-3) << name(arm);
    EXPECT_NE(report.tau[k], 0.0) << name(arm);
  }
}

}  // namespace
}  // namespace raven2_trainer::raven
