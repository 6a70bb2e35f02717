#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/faults/packet_faults.h"

namespace raven2_trainer::faults {
namespace {

/** On the green insertion's mpos, from cycle 2, for six cycles. */
Fault onMotor(FaultKind kind, double value) {
  Fault fault;
  fault.id = 1;
  fault.site = FaultSite::kStateEstimate;
  fault.variable = FaultVariable::kMpos;
  fault.kind = kind;
  fault.trigger = FaultTrigger::kPowerOn;
  fault.arm = 1;
  fault.channel = kInsertion;
  fault.first_tick = 2;
  fault.duration_ticks = 6;
  fault.value = value;
  return fault;
}

FaultEngine armed(const std::vector<Fault>& faults) {
  FaultPlan plan;
  plan.generation = 1;
  for (const Fault& fault : faults)
    plan.faults[plan.count++] = fault;
  FaultEngine engine(faults[0].host);
  engine.setPlan(plan);
  return engine;
}

/** What becomes of 10, 11, 12, ... */
std::vector<double> seriesOf(const Fault& fault, int count = 10) {
  FaultEngine engine = armed({fault});
  std::vector<double> out;
  for (int i = 0; i < count; ++i) {
    engine.beginCycle({});
    out.push_back(engine.apply(FaultVariable::kMpos, Arm::kGreen, kInsertion, 10.0 + i));
  }
  return out;
}

using Series = std::vector<double>;

TEST(FaultKinds, EachDoesWhatItsNameSays) {
  EXPECT_EQ(seriesOf(onMotor(FaultKind::kStuckAt, 3)), (Series{10, 11, 3, 3, 3, 3, 3, 3, 18, 19}));
  EXPECT_EQ(seriesOf(onMotor(FaultKind::kAdd, 3)), (Series{10, 11, 15, 16, 17, 18, 19, 20, 18, 19}));
  EXPECT_EQ(seriesOf(onMotor(FaultKind::kAddAndHold, 3)), (Series{10, 11, 15, 15, 15, 15, 15, 15, 18, 19}));
  EXPECT_EQ(seriesOf(onMotor(FaultKind::kScale, 2)), (Series{10, 11, 24, 26, 28, 30, 32, 34, 18, 19}));
  EXPECT_EQ(seriesOf(onMotor(FaultKind::kSignFlip, 0)), (Series{10, 11, -12, -13, -14, -15, -16, -17, 18, 19}));
  EXPECT_EQ(seriesOf(onMotor(FaultKind::kHoldLast, 0)), (Series{10, 11, 11, 11, 11, 11, 11, 11, 18, 19}));
}

TEST(FaultKinds, ARampGoesFromWhereItBeganAndStays) {
  Fault ramp = onMotor(FaultKind::kRamp, 112);
  ramp.ramp_ticks = 4;
  EXPECT_EQ(seriesOf(ramp), (Series{10, 11, 37, 62, 87, 112, 112, 112, 18, 19}));
}

TEST(FaultKinds, ADriftGrowsOnTopOfTheNumberAndStays) {
  Fault drift = onMotor(FaultKind::kDrift, 100);
  drift.ramp_ticks = 4;
  EXPECT_EQ(seriesOf(drift), (Series{10, 11, 37, 63, 89, 115, 116, 117, 18, 19}));
}

TEST(FaultKinds, RandomOnceIsDrawnAnewEachTimeItComesAndForEachElement) {
  Fault fault = onMotor(FaultKind::kRandomOnce, 0);
  fault.low = 100;
  fault.high = 200;
  fault.channel = -1;
  fault.duration_ticks = 2;
  fault.period_ticks = 4;
  FaultEngine engine = armed({fault});
  std::vector<JointArray> out;
  for (int i = 0; i < 8; ++i) {
    engine.beginCycle({});
    JointArray values{1, 2, 3, 4, 5, 6, 7};
    engine.applyAll(FaultVariable::kMpos, Arm::kGreen, &values);
    out.push_back(values);
  }
  EXPECT_EQ(out[1][0], 1.0);
  EXPECT_GE(out[2][0], 100.0);
  EXPECT_EQ(out[2], out[3]);
  EXPECT_EQ(out[4][6], 7.0);
  EXPECT_NE(out[6], out[2]);
  EXPECT_NE(out[2][0], out[2][1]);
}

TEST(FaultKinds, IntermittentActsAndRestsInTurns) {
  Fault flip = onMotor(FaultKind::kStuckAt, 0);
  flip.half_period_ticks = 2;
  EXPECT_EQ(seriesOf(flip), (Series{10, 11, 0, 0, 14, 15, 0, 0, 18, 19}));
}

TEST(FaultKinds, RandomStaysInItsRangeAndFollowsItsSeed) {
  Fault noise = onMotor(FaultKind::kRandom, 0);
  noise.low = -2;
  noise.high = 5;
  noise.duration_ticks = 10000;
  noise.seed = 4;
  const Series one = seriesOf(noise, 10002);
  double sum = 0;
  for (std::size_t i = 2; i < one.size(); ++i) {
    EXPECT_GE(one[i], -2.0);
    EXPECT_LT(one[i], 5.0);
    sum += one[i];
  }
  EXPECT_NEAR(sum / 10000, 1.5, 4 * 7 / std::sqrt(12.0 * 10000));
  EXPECT_EQ(one, seriesOf(noise, 10002));
  noise.seed = 5;
  EXPECT_NE(one, seriesOf(noise, 10002));
}

TEST(FaultKinds, EveryActivationHasItsOwnOnset) {
  Fault fault = onMotor(FaultKind::kAddAndHold, 100);
  fault.duration_ticks = 1;
  fault.period_ticks = 3;
  EXPECT_EQ(seriesOf(fault, 9), (Series{10, 11, 112, 13, 14, 115, 16, 17, 118}));
}

TEST(FaultKinds, RowsActOneAfterTheOther) {
  Fault add = onMotor(FaultKind::kAdd, 1), scale = onMotor(FaultKind::kScale, 10);
  FaultEngine engine = armed({add, scale});
  for (int i = 0; i < 3; ++i)
    engine.beginCycle({});
  EXPECT_EQ(engine.apply(FaultVariable::kMpos, Arm::kGreen, kInsertion, 4.0), 50.0);
  EXPECT_EQ(engine.activeMask(), 3);
}

TEST(FaultKinds, AllElementsOrOne) {
  Fault fault = onMotor(FaultKind::kStuckAt, 7);
  fault.arm = -1;
  fault.channel = -1;
  fault.first_tick = 0;
  FaultEngine engine = armed({fault});
  engine.beginCycle({});
  JointArray values{1, 2, 3, 4, 5, 6, 8};
  engine.applyAll(FaultVariable::kMpos, Arm::kGold, &values);
  EXPECT_EQ(values, (JointArray{7, 7, 7, 7, 7, 7, 7}));
  engine.applyAll(FaultVariable::kMvel, Arm::kGold, &values);
  EXPECT_EQ(values[0], 7.0);
}

/** One row on the relay's stream, from the first cycle. */
FaultEngine onStream(FaultVariable variable, FaultKind kind, double value, std::int8_t channel) {
  Fault fault = onMotor(kind, value);
  fault.host = FaultHost::kRelay;
  fault.site = FaultSite::kNetworkLayer;
  fault.variable = variable;
  fault.arm = 0;
  fault.channel = channel;
  fault.first_tick = 0;
  FaultEngine engine = armed({fault});
  engine.beginCycle({});
  return engine;
}

TEST(PacketFaults, AScaledTurnIsTheSameAxisAndAnotherAngle) {
  FaultEngine engine = onStream(FaultVariable::kTurn, FaultKind::kScale, 3.0, -1);
  const double half = 0.05;
  const Quat q{0.6 * std::sin(half), 0.0, 0.8 * std::sin(half), std::cos(half)};
  const Quat turned = faultedRotation(&engine, Arm::kGold, q);
  EXPECT_NEAR(turned[0], 0.6 * std::sin(3 * half), 1e-12);
  EXPECT_NEAR(turned[2], 0.8 * std::sin(3 * half), 1e-12);
  EXPECT_NEAR(turned[3], std::cos(3 * half), 1e-12);
  EXPECT_EQ(faultedRotation(&engine, Arm::kGreen, q), q) << "the other arm, to the bit";
}

TEST(PacketFaults, RawQuaternionsNeedNotStayUnit) {
  FaultEngine engine = onStream(FaultVariable::kQuaternion, FaultKind::kStuckAt, 1000.0, 3);
  EXPECT_EQ(faultedRotation(&engine, Arm::kGold, kIdentityQuat)[3], 1000.0);
}

TEST(PacketFaults, NumbersOfPacketsAndGraspAreWhole) {
  FaultEngine engine = onStream(FaultVariable::kSequence, FaultKind::kStuckAt, 0.0, -1);
  MasterCommand command;
  command.sequence = 4294967295U;
  command.dgrasp[0] = 0.0014;
  applyToCommand(&engine, &command);
  EXPECT_EQ(command.sequence, 0U);
  EXPECT_NEAR(command.dgrasp[0], 0.001, 1e-15);
}

TEST(PacketFaults, WithNothingArmedACommandStaysToTheBit) {
  FaultEngine engine(FaultHost::kRelay);
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    engine.beginCycle({true, 3, {}});
    MasterCommand command;
    command.sequence = random.next();
    for (double& x : command.dp_I[1])
      x = random.uniform(-1e-3, 1e-3);
    const MasterCommand before = command;
    applyToCommand(&engine, &command);
    EXPECT_EQ(command.dp_I, before.dp_I);
    EXPECT_EQ(command.dq_I, before.dq_I);
    EXPECT_EQ(command.sequence, before.sequence);
  }
}

}  // namespace
}  // namespace raven2_trainer::faults
