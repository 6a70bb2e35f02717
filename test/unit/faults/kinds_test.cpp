#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
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

/** The values that the fault makes of 10, 11, 12, ... */
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

/** Every kind that remembers something of an element, at the cycle of its onset. */
TEST(FaultKinds, EveryElementOfBothArmsHasItsOwnMemory) {
  const auto valueOf = [](Arm arm, std::size_t joint, int cycle) {
    return 100.0 * static_cast<double>(index(arm) + 1) + 10.0 * static_cast<double>(joint) + cycle;
  };
  for (const FaultKind kind : {FaultKind::kAddAndHold, FaultKind::kRamp, FaultKind::kHoldLast}) {
    Fault fault = onMotor(kind, 5.0);
    fault.arm = fault.channel = -1;
    fault.ramp_ticks = 2;
    FaultEngine engine = armed({fault});
    for (int cycle = 0; cycle < 3; ++cycle) {
      engine.beginCycle({});
      for (const Arm arm : kArms) {
        for (std::size_t j = 0; j < kJointCount; ++j) {
          const double onset = valueOf(arm, j, 2), value = valueOf(arm, j, cycle);
          const double expected = kind == FaultKind::kAddAndHold ? onset + 5.0
                                  : kind == FaultKind::kRamp     ? 0.5 * (onset + 5.0)
                                                                 : valueOf(arm, j, 1);
          EXPECT_EQ(engine.apply(FaultVariable::kMpos, arm, j, value), cycle < 2 ? value : expected)
              << kFaultKindNames[static_cast<std::size_t>(kind)] << " " << name(arm) << " " << kJointNames[j];
        }
      }
    }
  }
}

TEST(FaultKinds, RowsOfOneSeedDrawDifferentNumbersForEachArmAndJoint) {
  std::set<double> drawn;
  for (const std::int8_t arm : {-1, 0, 1}) {
    for (const std::int8_t joint : {0, 1, 2}) {
      Fault noise = onMotor(FaultKind::kRandom, 0);
      noise.low = 0, noise.high = 1;
      noise.first_tick = 0;
      noise.arm = arm;
      noise.channel = joint;
      FaultEngine engine = armed({noise});
      engine.beginCycle({});
      const Arm on = arm == 1 ? Arm::kGreen : Arm::kGold;
      drawn.insert(engine.apply(FaultVariable::kMpos, on, static_cast<std::size_t>(joint), 5.0));
    }
  }
  EXPECT_EQ(drawn.size(), 9U);
}

TEST(FaultKinds, WholeNumbersSaturateAtBothEnds) {
  for (const double factor : {-1e6, 1e6}) {
    FaultEngine engine = armed({onMotor(FaultKind::kScale, factor)});
    for (int i = 0; i < 3; ++i)
      engine.beginCycle({});
    EXPECT_EQ(engine.applyInt(FaultVariable::kMpos, Arm::kGreen, kInsertion, 1000000),
              factor < 0.0 ? std::numeric_limits<std::int32_t>::min() : std::numeric_limits<std::int32_t>::max());
  }
}

TEST(FaultKinds, TheActiveIdIsThatOfTheFirstRowThatActs) {
  Fault later = onMotor(FaultKind::kAdd, 1), now = onMotor(FaultKind::kAdd, 1);
  later.first_tick = 100;
  now.id = 2;
  FaultEngine engine = armed({later, now});
  for (int i = 0; i < 3; ++i)
    engine.beginCycle({});
  EXPECT_EQ(engine.activeMask(), 2);
  EXPECT_EQ(engine.activeId(), 2U);
}

/** One row on the relay's stream, from the first cycle. */
FaultEngine onStream(FaultVariable variable, FaultKind kind, double value, std::int8_t channel, Arm arm = Arm::kGold) {
  Fault fault = onMotor(kind, value);
  fault.host = FaultHost::kRelay;
  fault.site = FaultSite::kNetworkLayer;
  fault.variable = variable;
  fault.arm = static_cast<std::int8_t>(index(arm));
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

/** x, y, z, w of a rotation by `angle` [rad] about `axis`. */
Quat quaternionOf(const Vec3& axis, double angle) {
  const double s = std::sin(angle / 2.0);
  return {axis[0] * s, axis[1] * s, axis[2] * s, std::cos(angle / 2.0)};
}

TEST(PacketFaults, AScaledTurnIsThatOfTheShorterWayRoundForBothArms) {
  // GIVEN any rotation of less than half a revolution, as its quaternion and as the negative, the same rotation
  Random random(13);
  for (const Arm arm : kArms) {
    FaultEngine engine = onStream(FaultVariable::kTurn, FaultKind::kScale, 0.5, -1, arm);
    for (int i = 0; i < 200; ++i) {
      Vec3 axis{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
      const double length = std::hypot(axis[0], axis[1], axis[2]), angle = random.uniform(-3.1, 3.1);
      for (double& a : axis)
        a /= length;
      const Quat q = quaternionOf(axis, angle), expected = quaternionOf(axis, 0.5 * angle);
      for (const double sign : {-1.0, 1.0}) {
        const Quat turned = faultedRotation(&engine, arm, {sign * q[0], sign * q[1], sign * q[2], sign * q[3]});
        for (std::size_t k = 0; k < 4; ++k)
          ASSERT_NEAR(turned[k], expected[k], 1e-12) << "sign " << sign << ", angle " << angle;
      }
    }
  }
}

TEST(PacketFaults, ATurnAddedToWhatIsNoRotationIsThatTurn) {
  FaultEngine engine = onStream(FaultVariable::kTurn, FaultKind::kAdd, 0.2, 1);
  const double nan = std::nan("");
  for (const Quat& none : {Quat{0.0, 0.0, 0.0, 0.0}, Quat{0.0, 0.0, 0.0, -2.0}, Quat{nan, 0.0, 0.0, 1.0}}) {
    const Quat turned = faultedRotation(&engine, Arm::kGold, none);
    EXPECT_NEAR(turned[1], std::sin(0.1), 1e-15);
    EXPECT_NEAR(turned[3], std::cos(0.1), 1e-15);
  }
}

/** A command in which all numbers differ, also between the two arms. */
MasterCommand fullCommand(std::uint8_t pedal = kSurgeonsPedal) {
  MasterCommand command;
  command.sequence = 1000;
  command.pedal = pedal;
  command.dp_I = {Vec3{1e-6, 2e-6, 3e-6}, Vec3{-4e-6, 5e-6, -6e-6}};
  command.dq_I = {quaternionOf({1.0, 0.0, 0.0}, 0.02), quaternionOf({0.0, 0.6, 0.8}, -0.03)};
  command.dgrasp = {0.011, -0.022};
  return command;
}

void expectNear(const MasterCommand& a, const MasterCommand& b, const std::string& what) {
  for (const Arm arm : kArms) {
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(at(a.dp_I, arm)[i], at(b.dp_I, arm)[i], 1e-12) << what << " " << name(arm);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(at(a.dq_I, arm)[i], at(b.dq_I, arm)[i], 1e-12) << what << " " << name(arm);
    EXPECT_NEAR(at(a.dgrasp, arm), at(b.dgrasp, arm), 1e-12) << what << " " << name(arm);
  }
  EXPECT_EQ(a.pedal, b.pedal) << what;
  EXPECT_EQ(a.sequence, b.sequence) << what;
}

TEST(PacketFaults, EachChangesItsNumberOfItsArmAndNothingElse) {
  for (const Arm arm : kArms) {
    for (std::int8_t axis = 0; axis < 3; ++axis) {
      FaultEngine engine = onStream(FaultVariable::kIncrement, FaultKind::kAdd, 350.0, axis, arm);
      MasterCommand command = fullCommand(), expected = fullCommand();
      at(expected.dp_I, arm)[static_cast<std::size_t>(axis)] += 350e-6;
      applyToCommand(&engine, &command);
      expectNear(command, expected, "increment");
    }
    FaultEngine grasp = onStream(FaultVariable::kGrasp, FaultKind::kAdd, 7.0, -1, arm);
    MasterCommand command = fullCommand(), expected = fullCommand();
    at(expected.dgrasp, arm) += 0.007;
    applyToCommand(&grasp, &command);
    expectNear(command, expected, "grasp");
    FaultEngine turn = onStream(FaultVariable::kTurn, FaultKind::kSignFlip, 0.0, -1, arm);
    command = expected = fullCommand();
    for (std::size_t i = 0; i < 3; ++i)
      at(expected.dq_I, arm)[i] *= -1.0;
    applyToCommand(&turn, &command);
    expectNear(command, expected, "turn");
  }
}

TEST(PacketFaults, ThePedalKeepsItsOwnerUnlessItIsTurnedOver) {
  for (const std::uint8_t pedal : {std::uint8_t{0}, kSurgeonsPedal, kClientsPedal}) {
    for (const double stuck : {0.0, 1.0, -5.0}) {
      FaultEngine engine = onStream(FaultVariable::kPedal, FaultKind::kStuckAt, stuck, -1);
      MasterCommand command = fullCommand(pedal), expected = fullCommand(pedal);
      if (stuck == 0.0) expected.pedal = 0;
      if (stuck != 0.0 && pedal == 0) expected.pedal = kSurgeonsPedal;
      applyToCommand(&engine, &command);
      expectNear(command, expected, "pedal");
    }
  }
}

TEST(PacketFaults, SequencesAreRoundedAndStayInTheirThirtyTwoBits) {
  const auto after = [](FaultKind kind, double value, std::uint32_t sequence) {
    FaultEngine engine = onStream(FaultVariable::kSequence, kind, value, -1);
    return faultedSequence(&engine, sequence);
  };
  EXPECT_EQ(after(FaultKind::kScale, 0.5, 7), 4U);
  EXPECT_EQ(after(FaultKind::kScale, 0.25, 7), 2U);
  EXPECT_EQ(after(FaultKind::kAdd, 4294967295.0, 7), 4294967295U);
  EXPECT_EQ(after(FaultKind::kSignFlip, 0.0, 7), 0U);
  EXPECT_EQ(after(FaultKind::kStuckAt, std::nan(""), 7), 0U);
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
