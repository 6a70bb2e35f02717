#include "unit/plant/closed_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/raven/board_channels.h"

// Control software and plant together: the behaviour of the whole emulated robot.

namespace raven2_trainer::plant {
namespace {

using test::ClosedLoop;
using test::trainerConfig;

constexpr double kMm = 1e-3;

/** Minimum-jerk stroke of the gold tip, one packet a cycle, remainders of the micrometre carried. */
class Stroke {
 public:
  Stroke(const Vector3& travel_I, double peak_speed)
      : travel_I_(travel_I), ticks_(static_cast<int>(1875.0 * travel_I.norm() / peak_speed)) {}

  int ticks() const { return ticks_; }

  std::array<int, 3> next() {
    const double s = std::min(1.0, static_cast<double>(++tick_) / ticks_);
    const Vector3 wanted_um = travel_I_ * (s * s * s * (10 - 15 * s + 6 * s * s)) * 1e6;
    std::array<int, 3> step{};
    for (Eigen::Index i = 0; i < 3; ++i) {
      step[static_cast<std::size_t>(i)] = static_cast<int>(std::lround(wanted_um[i] - sent_um_[i]));
      sent_um_[i] += step[static_cast<std::size_t>(i)];
    }
    return step;
  }

  Vector3 sent() const { return sent_um_ * 1e-6; }

 private:
  Vector3 travel_I_;
  Vector3 sent_um_{0, 0, 0};
  int ticks_;
  int tick_{0};
};

Fault shoulderStuckAt(double value) {
  Fault fault;
  fault.id = 1;
  fault.site = FaultSite::kPutUsbPacket;
  fault.variable = FaultVariable::kDac;
  fault.kind = FaultKind::kStuckAt;
  fault.arm = 0;
  fault.channel = kShoulder;
  fault.first_tick = 500;
  fault.duration_ticks = 300;
  fault.value = value;
  return fault;
}

void inject(ClosedLoop* loop, double value) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = shoulderStuckAt(value);
  loop->software.setFaults(plan);
}

TEST(VirtualRaven, PowersOnHomesAndWaitsWithThePedalUp) {
  ClosedLoop loop;
  std::vector<RunLevel> levels;
  for (int k = 0; k < 5000; ++k) {
    loop.cycle();
    const RunLevel level = loop.software.state().runlevel;
    if (levels.empty() || levels.back() != level) levels.push_back(level);
  }
  EXPECT_EQ(levels, (std::vector<RunLevel>{RunLevel::kEStop, RunLevel::kInit, RunLevel::kPedalUp}));
  for (const Arm arm : kArms) {
    const JointArray q = loop.plant.jointPositions(arm);
    const Vector3 tip_home = kinematics::forward(loop.geometry, arm, loop.geometry.home).p;
    EXPECT_LT((loop.tip(arm) - tip_home).norm(), 1 * kMm);
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_NEAR(q[j], loop.geometry.home[j], 0.02) << kJointNames[j];
  }
}

TEST(VirtualRaven, FollowsThePedal) {
  ClosedLoop loop;
  ASSERT_TRUE(loop.engage());
  loop.drive(20, false);
  EXPECT_EQ(loop.software.state().runlevel, RunLevel::kPedalUp);
  loop.drive(20, true);
  EXPECT_EQ(loop.software.state().runlevel, RunLevel::kPedalDown);
}

TEST(VirtualRaven, TracksStrokesWithTheLagOfItsGains) {
  // 60 mm/s peak. Lag kd/kp plus friction: 35 ms at shoulder and elbow, 99 ms along the insertion (raven2.md 3.6, 6.2).
  const std::array<Vector3, 3> strokes{Vector3(0.03, 0, 0), Vector3(0, 0.03, 0), Vector3(-0.02, -0.02, -0.01)};
  for (const Vector3& travel : strokes) {
    ClosedLoop loop;
    ASSERT_TRUE(loop.engage());
    loop.drive(200, true);
    const Vector3 start = loop.tip(Arm::kGold);
    Stroke stroke(travel, 0.060);
    double worst = 0.0, error = 0.0;
    for (int k = 0; k < stroke.ticks() + 800; ++k) {
      loop.drive(1, true, stroke.next());
      const Vector3 wanted = start + control::itpToBase(Arm::kGold) * stroke.sent();
      error = (loop.tip(Arm::kGold) - wanted).norm();
      worst = std::max(worst, error);
    }
    EXPECT_LT(worst, 0.060 * 0.110);
    EXPECT_GT(worst, 0.060 * 0.027 * 0.5);  // it is a PD without feed-forward: it does lag
    EXPECT_LT(error, 0.5 * kMm);
    EXPECT_EQ(loop.software.state().runlevel, RunLevel::kPedalDown);
  }
}

TEST(VirtualRaven, StandsStillAtRest) {
  ClosedLoop loop;
  ASSERT_TRUE(loop.engage());
  loop.drive(1000, true);
  const Vector3 before = loop.tip(Arm::kGold);
  double noise = 0.0;
  for (int k = 0; k < 1000; ++k) {
    loop.drive(1, true);
    noise = std::max(noise, (loop.tip(Arm::kGold) - before).norm());
  }
  EXPECT_LT(noise, 0.05 * kMm);
}

TEST(VirtualRaven, ReEngagingMovesNothing) {
  ClosedLoop loop;
  ASSERT_TRUE(loop.engage());
  Stroke stroke({0.02, 0.01, 0.0}, 0.06);
  for (int k = 0; k < stroke.ticks(); ++k)
    loop.drive(1, true, stroke.next());
  loop.drive(500, false);
  const Vector3 resting = loop.tip(Arm::kGold);
  loop.drive(300, false, {500, 500, 500}, {500, 500, 500});  // the surgeon re-positions the hand: 150 mm of motion
  EXPECT_LT((loop.tip(Arm::kGold) - resting).norm(), 0.01 * kMm);
  loop.drive(500, true);
  EXPECT_LT((loop.tip(Arm::kGold) - resting).norm(), 0.1 * kMm);
}

TEST(VirtualRaven, SoftEStopDropsToEStopIn200MsAndRecoversWithoutHoming) {
  ClosedLoop loop;
  ASSERT_TRUE(loop.engage());
  for (int k = 0; k < 8; ++k)
    loop.send(true, {2000, 0, 0});  // 16 mm in one cycle: beyond the overdrive limit
  int to_estop = 0;
  while (loop.plant.runLevel() != RunLevel::kEStop && to_estop < 1000) {
    loop.drive(1, true);
    ++to_estop;
  }
  EXPECT_GE(to_estop, 175);
  EXPECT_LE(to_estop, 226);
  loop.drive(2000, true);
  EXPECT_EQ(loop.software.state().runlevel, RunLevel::kEStop);  // nobody has pressed start
  const Vector3 stopped = loop.tip(Arm::kGold);
  loop.plant.pressStart();
  int to_pedal = 0;
  while (loop.software.state().runlevel != RunLevel::kPedalDown && to_pedal < 1000) {
    loop.drive(1, true);
    ++to_pedal;
  }
  EXPECT_LT(to_pedal, 40);  // READY about 14 cycles after INIT, and 4 cycles a level
  EXPECT_LT((loop.tip(Arm::kGold) - stopped).norm(), 0.1 * kMm);
}

TEST(VirtualRaven, AStuckInRangeDacMovesTheTipWithoutAnEStop) {
  ClosedLoop clean, faulty;
  inject(&faulty, 800);  // recommended value of doc/virtual_raven.md
  ASSERT_TRUE(clean.engage());
  ASSERT_TRUE(faulty.engage());
  double deviation = 0.0;
  int active = 0;
  for (int k = 0; k < 2000; ++k) {
    clean.drive(1, true);
    faulty.drive(1, true);
    active += faulty.software.state().active_fault != 0 ? 1 : 0;
    deviation = std::max(deviation, (clean.tip(Arm::kGold) - faulty.tip(Arm::kGold)).norm());
    ASSERT_EQ(faulty.software.state().soft_estopped, 0);
  }
  EXPECT_EQ(active, 300);
  EXPECT_GT(deviation, 4 * kMm);
  EXPECT_EQ(faulty.software.state().runlevel, RunLevel::kPedalDown);
  EXPECT_LT((clean.tip(Arm::kGold) - faulty.tip(Arm::kGold)).norm(), 0.5 * kMm);  // and it comes back
}

TEST(VirtualRaven, ALargeStuckDacEndsInTheOverdriveCheck) {
  ClosedLoop loop;
  inject(&loop, -2500);
  ASSERT_TRUE(loop.engage());
  loop.drive(2000, true);
  EXPECT_EQ(loop.software.state().runlevel, RunLevel::kEStop);
}

std::vector<std::uint8_t> bytesOfARun(double fault_value) {
  ClosedLoop loop;
  if (fault_value != 0.0) inject(&loop, fault_value);
  EXPECT_TRUE(loop.engage());
  Random random(4);
  std::vector<std::uint8_t> bytes;
  for (int k = 0; k < 1500; ++k) {
    const auto um = [&random] { return static_cast<int>(random.uniform(-40, 40)); };
    loop.send(true, {um(), um(), um()}, {um(), um(), um()});
    loop.cycle();
    for (const raven::UsbInBytes& board : loop.plant.read())
      bytes.insert(bytes.end(), board.begin(), board.end());
  }
  return bytes;
}

TEST(VirtualRaven, TwoRunsGiveTheSameBytes) {
  EXPECT_EQ(bytesOfARun(0), bytesOfARun(0));
  EXPECT_EQ(bytesOfARun(800), bytesOfARun(800));
  EXPECT_NE(bytesOfARun(0), bytesOfARun(800));
}

TEST(VirtualRaven, TheBoardsIgnoreTheirCommandsInEStop) {
  Plant plant(test::dhRaven(trainerConfig().arms), trainerConfig().virtual_raven);
  const JointArray before = plant.jointPositions(Arm::kGold);
  raven::UsbOutBytes start_up{};  // the software's start-up write: full negative scale on all channels, no pins
  start_up[0] = 0x06;
  start_up[1] = 8;
  for (int k = 0; k < 100; ++k)
    plant.step({start_up, start_up});
  EXPECT_EQ(plant.jointPositions(Arm::kGold), before);
}

class PoweredArms : public ::testing::TestWithParam<Arm> {};

/** Large commands on all channels of one arm, in E-STOP and with the pedal up. */
TEST_P(PoweredArms, EStopCutsThePowerAndTheBrakesHoldEitherArm) {
  for (const RunLevel level : {RunLevel::kEStop, RunLevel::kPedalUp}) {
    VirtualRavenConfig config = trainerConfig().virtual_raven;
    for (PlantAxis& axis : config.plant.axes)
      axis.coulomb = axis.link_coulomb = 0.0;  // only the brakes hold
    Plant plant(test::dhRaven(trainerConfig().arms), config);
    if (level == RunLevel::kPedalUp) plant.startInPedalUp();
    const JointArray before = plant.jointPositions(GetParam());
    raven::UsbOut full;
    full.dac.fill(2000);
    PerArm<raven::UsbOutBytes> out{raven::encodeOut({}), raven::encodeOut({})};
    at(out, GetParam()) = raven::encodeOut(full);
    for (int k = 0; k < 50; ++k)
      plant.step(out);
    ASSERT_EQ(plant.runLevel(), level);
    const JointArray after = plant.jointPositions(GetParam());
    for (std::size_t j = kShoulder; j <= kInsertion; ++j)
      EXPECT_NEAR(after[j], before[j], 1e-12) << kJointNames[j];
    const double roll = std::abs(after[kToolRotation] - before[kToolRotation]);
    EXPECT_EQ(roll > 0.1, level == RunLevel::kPedalUp) << "tool joints have no brakes";
    EXPECT_EQ(roll < 0.01, level == RunLevel::kEStop);
  }
}

TEST_P(PoweredArms, EachBoardMovesItsOwnArm) {
  Plant plant(test::dhRaven(trainerConfig().arms), trainerConfig().virtual_raven);
  plant.startInPedalUp();
  const PerArm<JointArray> before{plant.jointPositions(Arm::kGold), plant.jointPositions(Arm::kGreen)};
  raven::UsbOut full;
  full.dac[raven::channelOf(kToolRotation)] = 2000;
  PerArm<raven::UsbOutBytes> out{raven::encodeOut({}), raven::encodeOut({})};
  at(out, GetParam()) = raven::encodeOut(full);
  for (int k = 0; k < 50; ++k)
    plant.step(out);
  const double moved = plant.jointPositions(GetParam())[kToolRotation] - at(before, GetParam())[kToolRotation];
  EXPECT_LT(moved, -0.1) << "a tool motor turns against its command (raven2.md 3.4)";
  const Arm other = otherArm(GetParam());
  EXPECT_NEAR(plant.jointPositions(other)[kToolRotation], at(before, other)[kToolRotation], 0.001);
}

INSTANTIATE_TEST_SUITE_P(Arms, PoweredArms, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

}  // namespace
}  // namespace raven2_trainer::plant
