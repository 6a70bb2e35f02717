#include "raven2_trainer/faults/fault_engine.h"

#include <gtest/gtest.h>

#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/faults/packet_faults.h"

namespace raven2_trainer::faults {
namespace {

Fault suddenJump() {
  Fault fault;
  fault.id = 1;
  fault.site = FaultSite::kPutUsbPacket;
  fault.host = FaultHost::kRobot;
  fault.kind = FaultKind::kStuckAt;
  fault.variable = FaultVariable::kDac;
  fault.arm = 0;
  fault.channel = kShoulder;
  fault.first_tick = 8000;
  fault.duration_ticks = 300;
  fault.period_ticks = 8000;
  fault.value = 1200.0;
  return fault;
}

FaultPlan planOf(const Fault& fault) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = fault;
  return plan;
}

double shoulderDac(FaultEngine* engine, double dac) {
  return engine->apply(FaultVariable::kDac, Arm::kGold, kShoulder, dac);
}

TEST(FaultEngine, WithoutFaultsEveryApplyIsTheIdentity) {
  FaultEngine engine(FaultHost::kRobot);
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    engine.beginCycle({true});
    const double value = random.uniform(-32768, 32767);
    EXPECT_EQ(shoulderDac(&engine, value), value);
    EXPECT_EQ(engine.activeId(), 0U);
  }
}

TEST(FaultEngine, ActsForExactly300CyclesEvery8000AfterPedalDown) {
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(suddenJump()));
  for (int i = 0; i < 500; ++i)
    engine.beginCycle({false});  // homing: the clock does not run yet
  std::vector<int> starts;
  int active = 0, before = 0;
  for (int i = 0; i < 33000; ++i) {
    engine.beginCycle({true});
    const bool acts = shoulderDac(&engine, 7.0) == 1200.0;
    EXPECT_EQ(acts, engine.activeId() == 1U);
    if (acts && before == 0) starts.push_back(i);
    active += acts ? 1 : 0;
    before = acts ? 1 : 0;
  }
  EXPECT_EQ(starts, (std::vector<int>{8000, 16000, 24000, 32000}));
  EXPECT_EQ(active, 1200);
}

TEST(FaultEngine, WaitsForThePedalAndKeepsItsLength) {
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(suddenJump()));
  int first = -1, active = 0;
  for (int i = 0; i < 9000; ++i) {
    engine.beginCycle({i < 7900 || i >= 8123});  // clutched when the fault is due
    if (engine.activeId() != 0) {
      if (first < 0) first = i;
      ++active;
    }
  }
  EXPECT_EQ(first, 8123);
  EXPECT_EQ(active, 300);
}

TEST(FaultEngine, TouchesOnlyItsTarget) {
  FaultEngine engine(FaultHost::kRobot);
  Fault fault = suddenJump();
  fault.first_tick = 0;
  engine.setPlan(planOf(fault));
  engine.beginCycle({true});
  ASSERT_EQ(engine.activeId(), 1U);
  EXPECT_EQ(engine.apply(FaultVariable::kDac, Arm::kGreen, kShoulder, 5.0), 5.0);
  EXPECT_EQ(engine.apply(FaultVariable::kDac, Arm::kGold, kElbow, 5.0), 5.0);
  EXPECT_EQ(engine.apply(FaultVariable::kEncoder, Arm::kGold, kShoulder, 5.0), 5.0);
}

TEST(FaultEngine, LeavesTheOtherHostAlone) {
  FaultEngine engine(FaultHost::kRelay);
  Fault fault = suddenJump();
  fault.first_tick = 0;
  engine.setPlan(planOf(fault));
  engine.beginCycle({true});
  EXPECT_EQ(engine.activeId(), 0U);
}

TEST(FaultEngine, KindsDoWhatTheySay) {
  Fault fault = suddenJump();
  fault.first_tick = 1;
  fault.value = 3.0;
  const struct {
    FaultKind kind;
    double expected;
  } cases[] = {
      {FaultKind::kStuckAt, 3.0}, {FaultKind::kAdd, 13.0}, {FaultKind::kScale, 30.0}, {FaultKind::kHoldLast, 4.0}};
  for (const auto& c : cases) {
    fault.kind = c.kind;
    FaultEngine engine(FaultHost::kRobot);
    engine.setPlan(planOf(fault));
    engine.beginCycle({true});
    EXPECT_EQ(shoulderDac(&engine, 4.0), 4.0) << "not due yet";
    engine.beginCycle({true});
    EXPECT_EQ(shoulderDac(&engine, 10.0), c.expected);
  }
}

TEST(FaultEngine, ClearingEndsAFaultAtOnceAndReArmingANewOneKeepsTheRest) {
  FaultEngine engine(FaultHost::kRobot);
  Fault fault = suddenJump();
  fault.first_tick = 0;
  FaultPlan plan = planOf(fault);
  engine.setPlan(plan);
  engine.beginCycle({true});
  ASSERT_EQ(engine.activeId(), 1U);
  plan.generation = 2;
  plan.count = 2;
  plan.faults[1] = fault;
  plan.faults[1].id = 2;
  plan.faults[1].channel = kElbow;
  plan.faults[1].first_tick = 100000;
  engine.setPlan(plan);
  EXPECT_EQ(engine.activeId(), 1U) << "the first keeps its progress";
  plan.generation = 3;
  plan.count = 0;
  engine.setPlan(plan);
  EXPECT_EQ(engine.activeId(), 0U);
}

TEST(FaultEngine, OnePeriodAfterAnotherFromLongAgoCostsNoTime) {
  Fault fault = suddenJump();
  fault.first_tick = -(std::int64_t{1} << 42U);  // counted up one by one it would take an hour
  fault.duration_ticks = 1;
  fault.period_ticks = 3;
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault));
  // Activations at first_tick + 3 n: 2^42 = 1 mod 3, so after the late one at tick 0 come ticks 2, 5, 8.
  std::vector<int> active;
  for (int tick = 0; tick < 9; ++tick) {
    engine.beginCycle({true});
    if (engine.activeId() != 0) active.push_back(tick);
  }
  EXPECT_EQ(active, (std::vector<int>{0, 2, 5, 8}));
}

TEST(FaultEngine, AnIncrementThatIsNoNumberBecomesNone) {
  Fault fault = suddenJump();
  fault.site = FaultSite::kNetworkLayer;
  fault.variable = FaultVariable::kIncrement;
  fault.kind = FaultKind::kScale;
  fault.channel = -1;
  fault.first_tick = 0;
  fault.value = 1e308;
  FaultPlan plan = planOf(fault);
  plan.count = 2;
  plan.faults[1] = fault;
  plan.faults[1].id = 2;
  plan.faults[1].value = 0.0;  // infinity times 0
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(plan);
  engine.beginCycle({true});
  MasterCommand command;
  command.pedal = 1;
  command.dp_I[0] = {100e-6, -100e-6, 0.0};
  applyToCommand(&engine, &command);
  EXPECT_EQ(command.dp_I[0], (Vec3{0.0, 0.0, 0.0}));
}

TEST(FaultEngine, CorruptsIncrementsInWholeMicrometresAndThePedal) {
  Fault fault;
  fault.id = 3;
  fault.site = FaultSite::kNetworkLayer;
  fault.host = FaultHost::kRelay;
  fault.kind = FaultKind::kAdd;
  fault.variable = FaultVariable::kIncrement;
  fault.arm = 1;
  fault.channel = 2;
  fault.duration_ticks = 10;
  fault.value = 350.0;
  FaultEngine engine(FaultHost::kRelay);
  engine.setPlan(planOf(fault));
  engine.beginCycle({true});
  MasterCommand command;
  command.pedal = 1;
  command.dp_I[1] = {1e-6, 2e-6, 3e-6};
  applyToCommand(&engine, &command);
  EXPECT_NEAR(command.dp_I[1][2], 353e-6, 1e-12);
  EXPECT_NEAR(command.dp_I[1][0], 1e-6, 1e-15);
  EXPECT_EQ(command.dp_I[0], Vec3{});
  EXPECT_EQ(command.pedal, 1);
}

}  // namespace
}  // namespace raven2_trainer::faults
