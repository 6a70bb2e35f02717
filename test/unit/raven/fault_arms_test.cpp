#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "raven2_trainer/core/fault_variables.h"
#include "unit/raven/raven_fixture.h"

// A fault on one arm changes that arm and no bit of the other one. Each variable, each arm. The reference is a second
// robot with the same boards and packets and no fault.

namespace raven2_trainer::raven {
namespace {

using test::Bench;

struct Row {
  FaultVariable variable;
  FaultKind kind;
  double value;
  int channel;
};

// Small enough that no check stops the robot, which would change both arms.
constexpr Row kRows[] = {
    {FaultVariable::kIncrement, FaultKind::kAdd, 20, -1},  {FaultVariable::kQuaternion, FaultKind::kAdd, 0.001, 0},
    {FaultVariable::kTurn, FaultKind::kAdd, 0.001, -1},    {FaultVariable::kGrasp, FaultKind::kAdd, 20, -1},
    {FaultVariable::kGetBoardIndex, FaultKind::kStuckAt, 2, -1},
    {FaultVariable::kReadResult, FaultKind::kStuckAt, UsbRead::kBusy, -1},
    {FaultVariable::kBuffer, FaultKind::kAdd, 1, 1},       {FaultVariable::kEncoder, FaultKind::kAdd, 40, -1},
    {FaultVariable::kMpos, FaultKind::kAdd, 0.05, -1},     {FaultVariable::kMvel, FaultKind::kAdd, 1, -1},
    {FaultVariable::kJpos, FaultKind::kAdd, 0.001, -1},    {FaultVariable::kJvel, FaultKind::kAdd, 0.1, -1},
    {FaultVariable::kPos, FaultKind::kAdd, 100, -1},       {FaultVariable::kOri, FaultKind::kAdd, 0.01, 1},
    {FaultVariable::kPosD, FaultKind::kAdd, 100, -1},      {FaultVariable::kJposD, FaultKind::kAdd, 0.001, -1},
    {FaultVariable::kMposD, FaultKind::kAdd, 0.05, -1},    {FaultVariable::kTauD, FaultKind::kAdd, 0.01, -1},
    {FaultVariable::kGain, FaultKind::kAdd, 0.2, -1},      {FaultVariable::kCurrentCmd, FaultKind::kAdd, 50, -1},
    {FaultVariable::kPutBoardIndex, FaultKind::kStuckAt, 2, -1},
    {FaultVariable::kOutputs, FaultKind::kAdd, 32, -1},    {FaultVariable::kDac, FaultKind::kAdd, 30, -1},
    {FaultVariable::kReturnedJpos, FaultKind::kAdd, 0.001, -1}};

FaultPlan planOf(const Row& row, Arm arm) {
  FaultPlan plan;
  plan.generation = plan.session = plan.count = 1;
  Fault& fault = plan.faults[0];
  fault.id = 7;
  fault.site = infoOf(row.variable).site;
  fault.variable = row.variable;
  fault.kind = row.kind;
  fault.trigger = FaultTrigger::kHand;
  fault.arm = static_cast<std::int8_t>(index(arm));
  fault.channel = static_cast<std::int8_t>(row.channel);
  fault.value = row.value;
  EXPECT_TRUE(isSound(fault)) << infoOf(row.variable).name;
  return plan;
}

/** At home with the pedal down, without the second that homing takes. */
struct Engaged : Bench {
  Engaged() {
    software.startAtHome();
    plc = RunLevel::kPedalUp;
    cycles(5);
    engage();
  }
};

template <typename Values>
void append(const Values& values, std::size_t first, std::size_t count, std::vector<double>* all) {
  for (std::size_t k = first; k < first + count; ++k)
    all->push_back(static_cast<double>(values[k]));
}

/** Everything that the robot reports of one arm: to its board, to the daemon, to ROS. */
std::vector<double> reportOf(const Bench& bench, Arm which) {
  const std::size_t arm = index(which);
  std::vector<double> all;
  const UsbOut& out = at(bench.out, which);
  append(out.dac, 0, kChannels, &all);
  all.push_back(out.pins);
  const RavenReport& report = bench.software.report();
  append(report.pos_um, 3 * arm, 3, &all);
  append(report.pos_d_um, 3 * arm, 3, &all);
  append(report.ori, 9 * arm, 9, &all);
  append(report.ori_d, 9 * arm, 9, &all);
  for (const auto* values : {&report.tau, &report.mpos, &report.jpos, &report.mvel, &report.mpos_d, &report.jpos_d})
    append(*values, kChannels * arm, kChannels, &all);
  append(report.encoder, kChannels * arm, kChannels, &all);
  all.push_back(at(report.grasp_d, which));
  const RobotState& state = bench.software.state();
  append(at(state.arms, which).dq, 0, kJointCount, &all);
  append(at(state.arms, which).dac, 0, kJointCount, &all);
  return all;
}

/** One cycle of slow motion. The packet moves, turns and closes both arms, each arm differently. */
void drive(Bench* bench) {
  wire::ItpPacket packet = bench->next();
  packet.delx_um = {12, -9};
  packet.dely_um = {-7, 11};
  packet.delz_um = {5, 8};
  packet.grasp_mrad = {1, 2};
  packet.Qx = {std::sin(0.0005), 0.0};
  packet.Qz = {0.0, std::sin(0.0004)};
  packet.Qw = {std::cos(0.0005), std::cos(0.0004)};
  bench->send(packet);
  bench->q[0][kShoulder] += 2e-5;
  bench->q[1][kElbow] -= 2e-5;
  bench->cycle();
  bench->software.returnState(0);
}

RobotState returned(Bench* bench) {
  RobotState state;
  EXPECT_TRUE(bench->software.nextReturned(&state));
  return state;
}

class FaultArms : public ::testing::TestWithParam<Arm> {};

TEST_P(FaultArms, AFaultOnOneArmChangesThatArmAlone) {
  for (const Row& row : kRows) {
    Engaged clean, struck;
    struck.software.setFaults(planOf(row, GetParam()));
    PerArm<bool> differs{};
    for (int k = 0; k < 20; ++k) {
      drive(&clean);
      drive(&struck);
      const RobotState expected = returned(&clean), got = returned(&struck);
      for (const Arm arm : kArms) {
        const bool is_same =
            reportOf(clean, arm) == reportOf(struck, arm) && at(expected.arms, arm).q == at(got.arms, arm).q;
        at(differs, arm) = at(differs, arm) || !is_same;
      }
    }
    ASSERT_EQ(struck.software.state().soft_estopped, 0) << infoOf(row.variable).name;
    EXPECT_TRUE(at(differs, GetParam())) << infoOf(row.variable).name << " does nothing";
    EXPECT_FALSE(at(differs, otherArm(GetParam()))) << infoOf(row.variable).name << " reaches the other arm";
  }
}

TEST_P(FaultArms, EitherArmsPinsStopTheRobot) {
  Engaged bench;
  bench.software.setFaults(planOf({FaultVariable::kInputs, FaultKind::kStuckAt, 0, -1}, GetParam()));
  bench.cycles(5);
  EXPECT_EQ(bench.level(), RunLevel::kEStop);
}

TEST_P(FaultArms, CountsStayWithin24Bits) {
  for (const double sign : {-1.0, 1.0}) {
    Engaged bench;
    bench.software.setFaults(
        planOf({FaultVariable::kEncoder, FaultKind::kAdd, sign > 0 ? 8388607.0 : -8388608.0, kShoulder}, GetParam()));
    PerArm<bool> is_at_end{};
    for (const double step : {-0.1, 0.2}) {  // on one side of zero the sum leaves the range
      at(bench.q, GetParam())[kShoulder] += step;
      bench.cycle();
      const std::int32_t count = -bench.software.report().encoder[index(GetParam()) * kChannels];
      ASSERT_GE(count, -8388608);
      ASSERT_LE(count, 8388607);
      at(is_at_end, GetParam()) = at(is_at_end, GetParam()) || count == (sign > 0 ? 8388607 : -8388608);
    }
    EXPECT_TRUE(at(is_at_end, GetParam())) << sign;
  }
}

TEST_P(FaultArms, TheOverdriveCheckStopsEitherArmOnEitherSide) {
  for (const double sign : {-1.0, 1.0}) {
    Engaged bench;
    bench.software.setFaults(
        planOf({FaultVariable::kCurrentCmd, FaultKind::kStuckAt, sign * 20001, kElbow}, GetParam()));
    bench.cycle();
    EXPECT_EQ(bench.software.state().soft_estopped, 1) << sign;
    EXPECT_EQ(at(bench.out, GetParam()).dac[kElbow], 0);
    EXPECT_NE(at(bench.out, otherArm(GetParam())).dac[kElbow], 0) << "in this cycle only that command";
    bench.cycle();
    for (const UsbOut& out : bench.out)
      EXPECT_EQ(out.dac[kShoulder], 0) << "in the next one all";
  }
}

TEST_P(FaultArms, TheClipHoldsForEitherArmOnEitherSide) {
  for (const int sign : {-1, 1}) {
    Engaged bench;
    bench.software.setFaults(
        planOf({FaultVariable::kCurrentCmd, FaultKind::kStuckAt, sign * 20000.0, kElbow}, GetParam()));
    bench.cycle();
    EXPECT_EQ(at(bench.out, GetParam()).dac[kElbow], sign * 2500);
    EXPECT_LT(std::abs(at(bench.out, otherArm(GetParam())).dac[kElbow]), 500);
    EXPECT_EQ(bench.software.state().soft_estopped, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, FaultArms, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

}  // namespace
}  // namespace raven2_trainer::raven
