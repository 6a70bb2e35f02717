#include <gtest/gtest.h>

#include "conformance/robot.h"
#include "raven2_trainer/core/fault_variables.h"

// raven2.md 1.4 and 1.5: which datagrams the robot uses, and their effect.

namespace raven2_trainer::conformance {
namespace {

// ---- 1.5, sequence rules, row by row
// -----------------------------------------------------------------------------------

TEST(Sequence, ZeroIsNeverUsedAndChangesNothing) {
  Robot robot;
  EXPECT_TRUE(robot.sendNumbered(1));
  EXPECT_FALSE(robot.sendNumbered(0));
  EXPECT_TRUE(robot.sendNumbered(2));
}

TEST(Sequence, AGapCostsThePacketBehindItToo) {
  Robot robot;
  EXPECT_TRUE(robot.sendNumbered(1));
  EXPECT_FALSE(robot.sendNumbered(3));
  EXPECT_TRUE(robot.sendNumbered(4));
}

TEST(Sequence, ARunNotStartingAtOneLosesItsFirstPacket) {
  Robot robot;
  EXPECT_FALSE(robot.sendNumbered(40));
  EXPECT_TRUE(robot.sendNumbered(41));
}

TEST(Sequence, DuplicatesAreDropped) {
  Robot robot;
  EXPECT_TRUE(robot.sendNumbered(1));
  EXPECT_FALSE(robot.sendNumbered(1));
  EXPECT_TRUE(robot.sendNumbered(2));
}

TEST(Sequence, TheNextNumberIsUsed) {
  Robot robot;
  for (std::uint32_t n = 1; n < 2000; ++n)
    EXPECT_TRUE(robot.sendNumbered(n));
}

TEST(Sequence, MoreThanAThousandBackIsANumberingReset) {
  Robot robot;
  robot.sendNumbered(1499);
  ASSERT_TRUE(robot.sendNumbered(1500));
  EXPECT_FALSE(robot.sendNumbered(499));  // becomes the new last number, but is dropped
  EXPECT_TRUE(robot.sendNumbered(500));
}

TEST(Sequence, AThousandBackIsLateAndLeavesLastUnchanged) {
  Robot robot;
  robot.sendNumbered(1499);
  ASSERT_TRUE(robot.sendNumbered(1500));
  EXPECT_FALSE(robot.sendNumbered(500));
  EXPECT_TRUE(robot.sendNumbered(1501));
}

TEST(Sequence, AMasterRestartedEarlyIsIgnoredUntilItPassesLast) {
  Robot robot;
  for (std::uint32_t n = 1; n <= 900; ++n)
    robot.sendNumbered(n);
  for (std::uint32_t n = 1; n <= 900; ++n)
    EXPECT_FALSE(robot.sendNumbered(n)) << n;
  EXPECT_TRUE(robot.sendNumbered(901));
}

TEST(Sequence, ComparesUnsignedAndDoesNotWrap) {
  constexpr std::uint32_t kLargest = std::numeric_limits<std::uint32_t>::max();
  Robot robot;
  EXPECT_FALSE(robot.sendNumbered(kLargest - 1));  // a gap, not a number below 0
  EXPECT_TRUE(robot.sendNumbered(kLargest));
  EXPECT_FALSE(robot.sendNumbered(0));
  EXPECT_FALSE(robot.sendNumbered(1));  // last + 1 is 0: a gap
  EXPECT_TRUE(robot.sendNumbered(2));
}

TEST(Sequence, LastSeqIs111ThenThatOfTheLastUsedPacket) {
  Robot robot;
  robot.cycle();
  EXPECT_EQ(robot.report().last_sequence, 111);
  robot.sendNumbered(40);
  robot.cycle();
  EXPECT_EQ(robot.report().last_sequence, 111);
  robot.sendNumbered(41);
  robot.cycle();
  EXPECT_EQ(robot.report().last_sequence, 41);
}

// ---- 1.5, size; 1.3, checksum
// ------------------------------------------------------------------------------------------

bool used(Robot* robot, std::size_t size) {
  const wire::ItpBytes packet = wire::encodeItp(robot->packet());
  std::vector<std::uint8_t> bytes(packet.begin(), packet.end());
  bytes.resize(std::max<std::size_t>(size, bytes.size()));
  const std::uint64_t before = robot->software.state().itp.applied;
  robot->software.receive(bytes.data(), size);
  return robot->software.state().itp.applied > before;
}

TEST(Size, LongerDatagramsAreTruncatedAndUsed) {
  Robot robot;
  for (const std::size_t size : {124, 125, 128, 134, 1400})
    EXPECT_TRUE(used(&robot, size)) << size;
}

TEST(Size, ShorterDatagramsAreRefused) {
  for (const std::size_t size : {0, 1, 52, 123}) {
    Robot robot;
    EXPECT_FALSE(used(&robot, size)) << size;
  }
}

TEST(Checksum, IsNotChecked) {
  Robot robot;
  wire::ItpPacket p = robot.packet();
  p.checksum = 12345;
  EXPECT_TRUE(robot.send(p));
}

// ---- 1.5, time-out
// -----------------------------------------------------------------------------------------------------

int cyclesUntilPedalUp(Robot* robot, bool duplicates) {
  wire::ItpPacket last = robot->packet();
  robot->send(last);
  for (int k = 0; k < 6000; ++k) {
    robot->cycle();
    raven::UsbOut out;
    raven::decodeOut(robot->out[0], &out);
    if ((out.pins & raven::pins::kFootPedal) == 0) return k;
    if (duplicates) robot->send(last);
  }
  return -1;
}

TEST(TimeOut, PedalComesUpAfter5000TicksOfSilence) {
  Robot robot;
  robot.engage();
  EXPECT_EQ(cyclesUntilPedalUp(&robot, false), 5001);  // more than 5000 since the tick that saw the packet
}

TEST(TimeOut, DuplicatesDoNotFeedIt) {
  Robot robot;
  robot.engage();
  EXPECT_EQ(cyclesUntilPedalUp(&robot, true), 5001);
}

TEST(TimeOut, AutomoveFeedsIt) {
  Robot robot;
  robot.engage();
  for (int k = 0; k < 12000; ++k) {
    if (k % 4000 == 0) robot.software.automove({}, {kIdentityQuat, kIdentityQuat});
    robot.cycle();
  }
  EXPECT_EQ(robot.level(), RunLevel::kPedalDown);
}

// ---- 1.4, axes
// ---------------------------------------------------------------------------------------------------------

struct AxisRow {
  Arm arm;
  int itp;   // 0 x, 1 y, 2 z
  int base;  // axis it becomes
  int sign;
};
// gold: base x = -itp z, y = -itp x, z = +itp y; green: x = -itp z, y = +itp x, z = -itp y
constexpr AxisRow kAxes[] = {{Arm::kGold, 0, 1, -1}, {Arm::kGold, 1, 2, 1},   {Arm::kGold, 2, 0, -1},
                             {Arm::kGreen, 0, 1, 1}, {Arm::kGreen, 1, 2, -1}, {Arm::kGreen, 2, 0, -1}};

class Axes : public ::testing::TestWithParam<AxisRow> {};

TEST_P(Axes, PositionsFollowTheTable) {
  const AxisRow row = GetParam();
  Robot robot;
  robot.engage();
  const auto before = robot.posD(row.arm);
  const auto other = robot.posD(row.arm == Arm::kGold ? Arm::kGreen : Arm::kGold);
  std::array<int, 3> um{};
  um[static_cast<std::size_t>(row.itp)] = 1000;
  robot.jump(row.arm, um);
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    EXPECT_EQ(robot.posD(row.arm)[i] - before[i], axis == row.base ? 1000 * row.sign : 0) << axis;
  }
  EXPECT_EQ(robot.posD(row.arm == Arm::kGold ? Arm::kGreen : Arm::kGold), other);
}

TEST_P(Axes, RotationsFollowTheTableInTheBaseFrame) {
  const AxisRow row = GetParam();
  Robot robot;
  robot.engage();
  const Matrix3 before = robot.oriD(row.arm);
  wire::ItpPacket p = robot.packet();
  const double angle = 0.05;
  PerArm<double>* const field[3] = {&p.Qx, &p.Qy, &p.Qz};
  at(*field[row.itp], row.arm) = std::sin(angle / 2);
  at(p.Qw, row.arm) = std::cos(angle / 2);
  robot.send(p);
  robot.cycle();
  const Matrix3 turn = Eigen::AngleAxisd(angle * row.sign, Vector3::Unit(row.base)).toRotationMatrix();
  EXPECT_LT((robot.oriD(row.arm) - turn * before).norm(), 1e-6);  // ori_d is float
}

/** A fault on one arm and axis of the packets, from the next cycle on. */
FaultPlan planOf(FaultVariable variable, FaultKind kind, double value, const AxisRow& row) {
  FaultPlan plan;
  plan.generation = plan.session = plan.count = 1;
  Fault& fault = plan.faults[0];
  fault.id = 1;
  fault.site = FaultSite::kNetworkLayer;
  fault.variable = variable;
  fault.kind = kind;
  fault.trigger = FaultTrigger::kHand;
  fault.arm = static_cast<std::int8_t>(index(row.arm));
  fault.channel = static_cast<std::int8_t>(row.itp);
  fault.value = value;
  fault.low = 1;  // a forged packet has the next number
  EXPECT_TRUE(isSound(fault));
  return plan;
}

TEST_P(Axes, FaultsOnIncrementsFollowTheTable) {
  const AxisRow row = GetParam();
  for (const FaultKind kind : {FaultKind::kAdd, FaultKind::kStuckAt}) {
    Robot robot;
    robot.engage();
    robot.software.setFaults(planOf(FaultVariable::kIncrement, kind, 700, row));
    robot.cycle();
    const PerArm<std::array<std::int32_t, 3>> before{robot.posD(Arm::kGold), robot.posD(Arm::kGreen)};
    robot.jump(row.arm, {0, 0, 0});
    for (const Arm arm : kArms) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        const bool moves = arm == row.arm && axis == row.base;
        EXPECT_EQ(robot.posD(arm)[i] - at(before, arm)[i], moves ? 700 * row.sign : 0) << name(arm) << axis;
      }
    }
  }
}

TEST_P(Axes, FaultsOnTurnsFollowTheTableWhicheverQuaternionIsSent) {
  const AxisRow row = GetParam();
  for (const double sign : {1.0, -1.0}) {  // a rotation has two quaternions
    Robot robot;
    robot.engage();
    robot.software.setFaults(planOf(FaultVariable::kTurn, FaultKind::kAdd, 0.05, row));
    robot.cycle();
    const PerArm<Matrix3> before{robot.oriD(Arm::kGold), robot.oriD(Arm::kGreen)};
    wire::ItpPacket p = robot.packet();
    PerArm<double>* const field[3] = {&p.Qx, &p.Qy, &p.Qz};
    p.Qw = {sign, sign};
    at(*field[row.itp], row.arm) = sign * std::sin(0.02);
    at(p.Qw, row.arm) = sign * std::cos(0.02);
    robot.send(p);
    robot.cycle();
    for (const Arm arm : kArms) {
      const double angle = arm == row.arm ? (0.04 + 0.05) * row.sign : 0.0;
      const Matrix3 turn = Eigen::AngleAxisd(angle, Vector3::Unit(row.base)).toRotationMatrix();
      EXPECT_LT((robot.oriD(arm) - turn * at(before, arm)).norm(), 1e-6) << name(arm) << " w " << p.Qw[0];
    }
  }
}

TEST_P(Axes, AForgedPacketFollowsTheTableTakesTheNextNumberAndPressesThePedal) {
  const AxisRow row = GetParam();
  Robot robot;
  robot.engage();
  robot.software.setFaults(planOf(FaultVariable::kPacket, FaultKind::kForge, 700, row));
  robot.cycle();
  const auto before = robot.posD(row.arm);
  const auto other = robot.posD(otherArm(row.arm));
  const std::uint64_t applied = robot.software.state().itp.applied;
  wire::ItpPacket up = robot.packet(0);
  robot.send(up);
  robot.cycle();
  EXPECT_EQ(robot.software.state().itp.applied, applied + 2);
  EXPECT_EQ(robot.report().last_sequence, static_cast<std::int32_t>(up.sequence + 1));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(robot.posD(row.arm)[i] - before[i], static_cast<int>(i) == row.base ? 700 * row.sign : 0) << i;
  EXPECT_EQ(robot.posD(otherArm(row.arm)), other);
  raven::UsbOut out;
  ASSERT_TRUE(raven::decodeOut(robot.out[0], &out));
  EXPECT_NE(out.pins & raven::pins::kFootPedal, 0) << "the forged packet presses the pedal that the master has lifted";
}

INSTANTIATE_TEST_SUITE_P(Table, Axes, ::testing::ValuesIn(kAxes));

TEST(Automove, IsInTheBaseFrameWithoutMap) {
  Robot robot;
  robot.engage();
  const auto before = robot.posD(Arm::kGreen);
  const Matrix3 R = robot.oriD(Arm::kGreen);
  const double s = std::sin(0.02), c = std::cos(0.02);
  robot.software.automove({Vec3{}, Vec3{100.9, -200.9, 300.0}}, {kIdentityQuat, Quat{0.0, 0.0, s, c}});
  robot.cycle();
  const auto after = robot.posD(Arm::kGreen);
  EXPECT_EQ(after[0] - before[0], 100);
  EXPECT_EQ(after[1] - before[1], -200);
  EXPECT_EQ(after[2] - before[2], 300);
  const Matrix3 turn = Eigen::AngleAxisd(0.04, Vector3::UnitZ()).toRotationMatrix();
  EXPECT_LT((robot.oriD(Arm::kGreen) - turn * R).norm(), 1e-6);
}

TEST(Automove, EachArmTakesItsOwn) {
  Robot robot;
  robot.engage();
  const PerArm<std::array<std::int32_t, 3>> before{robot.posD(Arm::kGold), robot.posD(Arm::kGreen)};
  const PerArm<Matrix3> R{robot.oriD(Arm::kGold), robot.oriD(Arm::kGreen)};
  const PerArm<Vec3> step{Vec3{10.0, 20.0, -30.0}, Vec3{-40.0, 50.0, 60.0}};
  const PerArm<Vector3> about{Vector3::UnitX(), Vector3::UnitY()};
  const double s = std::sin(0.01), c = std::cos(0.01);
  robot.software.automove(step, {Quat{s, 0.0, 0.0, c}, Quat{0.0, s, 0.0, c}});
  robot.cycle();
  for (const Arm arm : kArms) {
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(robot.posD(arm)[i] - at(before, arm)[i], static_cast<std::int32_t>(at(step, arm)[i])) << name(arm) << i;
    const Matrix3 turn = Eigen::AngleAxisd(0.02, at(about, arm)).toRotationMatrix();
    EXPECT_LT((robot.oriD(arm) - turn * at(R, arm)).norm(), 1e-6) << name(arm);
  }
}

// ---- 1.4, grasp
// --------------------------------------------------------------------------------------------------------

double graspAfter(Robot* robot, std::int32_t mrad) {
  wire::ItpPacket p = robot->packet();
  p.grasp_mrad = {mrad, mrad};
  robot->send(p);
  robot->cycle();
  EXPECT_EQ(robot->report().grasp_d[0], robot->report().grasp_d[1]);
  return robot->report().grasp_d[0];
}

TEST(Grasp, IncrementsCloseByMilliradians) {
  Robot robot;
  robot.engage();
  EXPECT_NEAR(robot.report().grasp_d[0], 1.570, 1e-9);
  EXPECT_NEAR(graspAfter(&robot, 100), 1.470, 1e-9);
  EXPECT_NEAR(graspAfter(&robot, -50), 1.520, 1e-9);
}

TEST(Grasp, IsClampedAtMinus10And90Degrees) {
  Robot robot;
  robot.engage();
  for (int k = 0; k < 40; ++k)
    graspAfter(&robot, 50);
  EXPECT_NEAR(graspAfter(&robot, 50), -0.174, 1e-9);
  for (int k = 0; k < 40; ++k)
    graspAfter(&robot, -50);
  EXPECT_NEAR(graspAfter(&robot, -50), 1.570, 1e-9);
}

TEST(Grasp, IsKeptThroughAClutchUnlessItIs45DegreesOff) {
  Robot robot;
  robot.engage();
  for (int k = 0; k < 10; ++k)
    graspAfter(&robot, 50);  // 1.070: within 45 degrees of jaws that are still open
  robot.send(robot.packet(0));
  robot.cycles(20);
  ASSERT_EQ(robot.level(), RunLevel::kPedalUp);
  robot.engage(10);
  EXPECT_NEAR(robot.report().grasp_d[0], 1.070, 1e-9);
}

}  // namespace
}  // namespace raven2_trainer::conformance
