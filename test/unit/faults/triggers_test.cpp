#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/faults/fault_engine.h"

namespace raven2_trainer::faults {
namespace {

/** Gold shoulder DAC stuck at 1 for three ticks. */
Fault stuck(FaultTrigger trigger, std::int64_t first_tick) {
  Fault fault;
  fault.id = 1;
  fault.site = FaultSite::kPutUsbPacket;
  fault.variable = FaultVariable::kDac;
  fault.kind = FaultKind::kStuckAt;
  fault.trigger = trigger;
  fault.arm = 0;
  fault.channel = kShoulder;
  fault.first_tick = first_tick;
  fault.duration_ticks = 3;
  fault.value = 1.0;
  return fault;
}

FaultEngine armed(const Fault& fault) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = fault;
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(plan);
  return engine;
}

/** Cycles 0 .. `count` - 1 in which the fault acts. */
template <typename CycleAt>
std::vector<int> actingCycles(FaultEngine engine, int count, CycleAt cycle_at) {
  std::vector<int> cycles;
  for (int i = 0; i < count; ++i) {
    engine.beginCycle(cycle_at(i));
    if (engine.activeMask() == 1) cycles.push_back(i);
  }
  return cycles;
}

TEST(FaultTriggers, PowerOnCountsFromTheFirstCycleWithThePedalUp) {
  EXPECT_EQ(actingCycles(armed(stuck(FaultTrigger::kPowerOn, 4)), 20, [](int) { return FaultCycle{}; }),
            (std::vector<int>{4, 5, 6}));
}

TEST(FaultTriggers, ByHandCountsFromWhereItWasArmed) {
  FaultEngine engine(FaultHost::kRobot);
  for (int i = 0; i < 100; ++i)
    engine.beginCycle({});
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = stuck(FaultTrigger::kHand, 2);
  engine.setPlan(plan);
  EXPECT_EQ(actingCycles(engine, 20, [](int) { return FaultCycle{}; }), (std::vector<int>{2, 3, 4}));
}

TEST(FaultTriggers, RunLevelCountsFromTheCycleThatReachesIt) {
  Fault fault = stuck(FaultTrigger::kRunLevel, 1);
  fault.threshold = 2.0;
  const auto level = [](int i) { return FaultCycle{false, i < 7 ? 1 : 2, {}}; };
  EXPECT_EQ(actingCycles(armed(fault), 20, level), (std::vector<int>{8, 9, 10}));
}

TEST(FaultTriggers, DistancesCountFromTheCycleThatComesSoNear) {
  for (const FaultTrigger trigger : {FaultTrigger::kTissueDistance, FaultTrigger::kTargetDistance}) {
    Fault fault = stuck(trigger, 0);
    fault.threshold = 0.005;
    const auto approach = [&](int i) {
      FaultCycle cycle;
      (trigger == FaultTrigger::kTissueDistance ? cycle.signals.tissue_distance : cycle.signals.target_distance) =
          0.010 - 0.001 * i;
      return cycle;
    };
    EXPECT_EQ(actingCycles(armed(fault), 9, approach), (std::vector<int>{5, 6, 7}));
    EXPECT_TRUE(actingCycles(armed(fault), 9, [](int) { return FaultCycle{}; }).empty()) << "nothing is near";
  }
}

TEST(FaultTriggers, AStepCountsFromWhereTheExerciseReachesIt) {
  Fault fault = stuck(FaultTrigger::kStep, 0);
  fault.threshold = 3.0;
  const auto exercise = [](int i) {
    FaultCycle cycle;
    cycle.pedal_down = true;
    cycle.signals.step = static_cast<std::uint32_t>(i / 4);
    return cycle;
  };
  EXPECT_EQ(actingCycles(armed(fault), 30, exercise), (std::vector<int>{12, 13, 14}));
}

TEST(FaultTriggers, AStepsFaultWaitsForThePedalAndThenLasts) {
  Fault fault = stuck(FaultTrigger::kStep, 4);
  fault.threshold = 1.0;
  const auto exercise = [](int i) {
    FaultCycle cycle;
    cycle.pedal_down = i < 5 || i == 12;  // up when it is due, four cycles behind the step
    cycle.signals.step = i >= 3 ? 1 : 0;
    return cycle;
  };
  EXPECT_EQ(actingCycles(armed(fault), 30, exercise), (std::vector<int>{12, 13, 14}));
}

TEST(FaultTriggers, AToolChangeIsTheNextPressOfTheButton) {
  const auto presses = [](int i) {
    FaultCycle cycle;
    cycle.signals.tool_changes = i < 5 ? 7 : 8;
    return cycle;
  };
  FaultEngine engine(FaultHost::kRobot);
  engine.beginCycle(presses(0));  // seven presses were before it was armed
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  plan.faults[0] = stuck(FaultTrigger::kToolChange, 0);
  engine.setPlan(plan);
  EXPECT_EQ(actingCycles(engine, 20, presses), (std::vector<int>{5, 6, 7}));
}

TEST(FaultTriggers, PacketsAreCountedFromTheFirstWithThePedalDown) {
  Fault fault = stuck(FaultTrigger::kPacket, 4);
  fault.site = FaultSite::kNetworkLayer;
  fault.variable = FaultVariable::kGrasp;
  fault.channel = 0;
  FaultEngine engine = armed(fault);
  std::vector<int> acting;
  for (int packet = 0; packet < 20; ++packet) {
    engine.beginCycle({});  // cycles do not count
    engine.beginCycle({});
    engine.beginPacket(packet >= 2);
    if (engine.activeMask() == 1) acting.push_back(packet);
  }
  EXPECT_EQ(acting, (std::vector<int>{6, 7, 8}));
}

TEST(FaultTriggers, WhatIsNoPacketsBeginsWithOneAndLastsForCycles) {
  FaultEngine engine = armed(stuck(FaultTrigger::kPacket, 4));
  std::vector<int> acting;
  for (int cycle = 0; cycle < 40; ++cycle) {
    if (cycle % 5 == 0) engine.beginPacket(cycle >= 10);  // the packets of a cycle come before it
    engine.beginCycle({});
    if (engine.activeMask() == 1) acting.push_back(cycle);
  }
  EXPECT_EQ(acting, (std::vector<int>{30, 31, 32}));
}

/** All beginnings (1) and ends (-1) that an engine reports. */
std::vector<int> toldBy(FaultEngine* engine) {
  std::vector<int> told;
  FaultChange change;
  while (engine->nextChange(&change))
    told.push_back(change.acts != 0 ? 1 : -1);
  return told;
}

FaultPlan planOf(const Fault& fault, std::uint64_t generation, std::uint32_t session) {
  FaultPlan plan;
  plan.generation = generation;
  plan.session = session;
  plan.count = 1;
  plan.faults[0] = fault;
  return plan;
}

FaultPlan suspended(std::uint64_t generation, std::uint32_t session) {
  FaultPlan plan;
  plan.generation = generation;
  plan.session = session;
  plan.is_suspended = 1;
  return plan;
}

constexpr FaultCycle kPedalDown{true, 3, {}};

TEST(FaultChanges, AreTheBeginningsAndTheEnds) {
  Fault fault = stuck(FaultTrigger::kPedalDown, 2);
  fault.period_ticks = 10;
  fault.count = 2;
  fault.row = 3;
  FaultEngine engine = armed(fault);
  std::vector<std::pair<int, int>> told;
  FaultChange change;
  for (int i = 0; i < 40; ++i) {
    engine.beginCycle(kPedalDown);
    while (engine.nextChange(&change)) {
      told.emplace_back(i, change.acts);
      EXPECT_EQ(change.number, told.size());
      EXPECT_EQ(change.id, 1U);
      EXPECT_EQ(change.row, 3);
      EXPECT_EQ(change.host, FaultHost::kRobot);
    }
  }
  EXPECT_EQ(told, (std::vector<std::pair<int, int>>{{2, 1}, {5, 0}, {12, 1}, {15, 0}}));
}

TEST(FaultChanges, ThatNobodyAskedForLeaveAGapInTheNumbers) {
  Fault fault = stuck(FaultTrigger::kPowerOn, 0);
  fault.duration_ticks = 1;
  fault.period_ticks = 2;
  FaultEngine engine = armed(fault);
  for (int i = 0; i < 101; ++i)
    engine.beginCycle({});
  EXPECT_EQ(toldBy(&engine).size(), 64U);
  engine.beginCycle({});
  FaultChange change;
  ASSERT_TRUE(engine.nextChange(&change));
  EXPECT_EQ(change.number, 102U);
}

TEST(FaultChanges, TellWhatAPlanTakesAway) {
  FaultEngine engine = armed(stuck(FaultTrigger::kPowerOn, 0));
  engine.beginCycle({});
  FaultPlan nothing;
  nothing.generation = 2;
  engine.setPlan(nothing);
  EXPECT_EQ(toldBy(&engine), (std::vector<int>{1, -1}));
}

TEST(FaultSessions, AnotherOneBeginsAnewWithTheNextPedalDown) {
  const Fault fault = stuck(FaultTrigger::kPedalDown, 2);
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault, 1, 7));
  for (int i = 0; i < 100; ++i)
    engine.beginCycle(kPedalDown);
  engine.setPlan(suspended(2, 7));
  engine.setPlan(planOf(fault, 3, 8));
  const auto pedal = [](int i) { return i < 5 ? FaultCycle{} : kPedalDown; };
  EXPECT_EQ(actingCycles(engine, 40, pedal), (std::vector<int>{7, 8, 9}));
}

TEST(FaultSessions, AnotherOneCountsItsPacketsFromItsOwnFirstPedalDown) {
  Fault fault = stuck(FaultTrigger::kPacket, 4);
  fault.site = FaultSite::kNetworkLayer;
  fault.variable = FaultVariable::kGrasp;
  fault.channel = 0;
  FaultEngine engine(FaultHost::kRobot);
  const auto actingPackets = [&engine](int pedal_at) {
    std::vector<int> acting;
    for (int packet = 0; packet < 40; ++packet) {
      engine.beginCycle({});
      engine.beginPacket(packet >= pedal_at);
      if (engine.activeMask() == 1) acting.push_back(packet);
    }
    return acting;
  };
  for (std::uint32_t session = 1; session <= 3; ++session) {
    engine.setPlan(planOf(fault, session, session));
    const int pedal_at = static_cast<int>(5 * session);
    EXPECT_EQ(actingPackets(pedal_at), (std::vector<int>{pedal_at + 4, pedal_at + 5, pedal_at + 6})) << session;
  }
}

TEST(FaultSessions, NothingOfTheOneBeforeGoesOnWithoutABreakBetweenThem) {
  // GIVEN the same fault, acting without end, in a session that follows another one at once
  Fault fault = stuck(FaultTrigger::kPedalDown, 2);
  fault.duration_ticks = 0;
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault, 1, 7));
  for (int i = 0; i < 10; ++i)
    engine.beginCycle(kPedalDown);
  ASSERT_EQ(engine.activeMask(), 1);
  engine.setPlan(planOf(fault, 2, 8));
  EXPECT_EQ(engine.activeMask(), 0);
  EXPECT_EQ(actingCycles(engine, 5, [](int) { return kPedalDown; }), (std::vector<int>{2, 3, 4}));
  EXPECT_EQ(toldBy(&engine), (std::vector<int>{1, -1}));
}

TEST(FaultSessions, TheEndOfAFaultIsToldOfTheSessionInWhichItBegan) {
  Fault fault = stuck(FaultTrigger::kHand, 0);
  fault.duration_ticks = 0;
  FaultEngine engine(FaultHost::kRobot);
  for (const std::uint32_t session : {7U, 8U}) {
    engine.setPlan(planOf(fault, session, session));
    engine.beginCycle({});
  }
  std::vector<std::pair<int, std::uint32_t>> told;
  FaultChange change;
  while (engine.nextChange(&change))
    told.emplace_back(change.acts, change.session);
  EXPECT_EQ(told, (std::vector<std::pair<int, std::uint32_t>>{{1, 7U}, {0, 7U}, {1, 8U}}));
}

TEST(FaultSessions, WhatStaysArmedWithinOneIsNotToldAgain) {
  Fault fault = stuck(FaultTrigger::kHand, 0);
  fault.duration_ticks = 0;
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault, 1, 7));
  engine.beginCycle({});
  engine.setPlan(planOf(fault, 2, 7));
  engine.beginCycle({});
  EXPECT_EQ(toldBy(&engine), (std::vector<int>{1}));
}

TEST(FaultSessions, AFaultThatIsDueLaterIsAnotherOne) {
  Fault fault = stuck(FaultTrigger::kHand, 0);
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault, 1, 7));
  for (int i = 0; i < 10; ++i)
    engine.beginCycle({});
  fault.first_tick = 2;
  engine.setPlan(planOf(fault, 2, 7));
  EXPECT_EQ(actingCycles(engine, 10, [](int) { return FaultCycle{}; }), (std::vector<int>{2, 3, 4}));
}

/** If any of these parts of a plan's row changes, the row is a different fault and starts again. */
TEST(FaultSessions, AFaultWithAnyPartChangedIsAnotherOne) {
  const Fault fault = stuck(FaultTrigger::kHand, 0);
  std::vector<Fault> others(12, fault);
  others[0].id = 2;
  others[1].arm = 1;
  others[2].channel = kElbow;
  others[3].value = 2.0;
  others[4].kind = FaultKind::kAdd;
  others[5].seed = 2;
  others[6].row = 1;
  others[7].arming = 1;
  others[8].low = -1.0;
  others[9].high = 1.0;
  others[10].variable = FaultVariable::kTauD;
  others[11].trigger = FaultTrigger::kPowerOn;
  for (const Fault& other : others) {
    FaultEngine engine(FaultHost::kRobot);
    engine.setPlan(planOf(fault, 1, 7));
    for (int i = 0; i < 10; ++i)
      engine.beginCycle({});
    engine.setPlan(planOf(other, 2, 7));
    EXPECT_EQ(actingCycles(engine, 10, [](int) { return FaultCycle{}; }), (std::vector<int>{0, 1, 2}))
        << &other - others.data();
  }
}

TEST(FaultTriggers, RunLevelIsThatOneAndNoHigherOne) {
  for (const double wanted : {0.0, 1.0, 2.0, 3.0}) {
    Fault fault = stuck(FaultTrigger::kRunLevel, 0);
    fault.threshold = wanted;
    for (int level = -1; level <= 3; ++level) {
      const auto acting = actingCycles(armed(fault), 3, [level](int) { return FaultCycle{false, level, {}}; });
      EXPECT_EQ(!acting.empty(), level == wanted) << wanted << " at " << level;
    }
  }
}

TEST(FaultSessions, TheSameIsNotHitTwiceByWhatCameOnce) {
  const Fault fault = stuck(FaultTrigger::kPedalDown, 2);
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault, 1, 7));
  for (int i = 0; i < 10; ++i)
    engine.beginCycle(kPedalDown);
  engine.setPlan(suspended(2, 7));
  for (int i = 0; i < 10; ++i)
    engine.beginCycle(kPedalDown);
  engine.setPlan(planOf(fault, 3, 7));
  EXPECT_TRUE(actingCycles(engine, 40, [](int) { return kPedalDown; }).empty());
}

TEST(FaultSessions, NothingActsWhileItsLinkIsDownAndTimeGoesOn) {
  Fault fault = stuck(FaultTrigger::kPedalDown, 2);
  fault.duration_ticks = 10;
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault, 1, 7));
  const auto run = [&](int cycles) {
    int acted = 0;
    for (int i = 0; i < cycles; ++i) {
      engine.beginCycle(kPedalDown);
      const bool acts = engine.activeMask() != 0;
      EXPECT_EQ(engine.apply(FaultVariable::kDac, Arm::kGold, kShoulder, 5.0), acts ? 1.0 : 5.0);
      acted += acts ? 1 : 0;
    }
    return acted;
  };
  EXPECT_EQ(run(5), 3);
  engine.setPlan(suspended(2, 7));
  EXPECT_EQ(run(4), 0);
  engine.setPlan(planOf(fault, 3, 7));
  EXPECT_EQ(run(20), 3) << "three before and four within of ten";
  EXPECT_EQ(toldBy(&engine), (std::vector<int>{1, -1, 1, -1}));
}

TEST(FaultSessions, WhatIsArmedAnewWithinOneBeginsAnew) {
  const Fault fault = stuck(FaultTrigger::kHand, 0);
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(planOf(fault, 1, 7));
  for (int i = 0; i < 10; ++i)
    engine.beginCycle({});
  Fault again = fault;
  again.arming = 1;  // nobody saw that it was gone in between
  engine.setPlan(planOf(again, 3, 7));
  EXPECT_EQ(actingCycles(engine, 10, [](int) { return FaultCycle{}; }), (std::vector<int>{0, 1, 2}));
}

TEST(FaultHold, WhatIsFrozenAfterItIsOfAfterIt) {
  Fault frozen = stuck(FaultTrigger::kPowerOn, 2);
  frozen.kind = FaultKind::kHoldLast;
  frozen.duration_ticks = 0;
  FaultEngine engine = armed(frozen);
  const auto apply = [&](double value) { return engine.apply(FaultVariable::kDac, Arm::kGold, kShoulder, value); };
  engine.beginCycle({});
  EXPECT_EQ(apply(5.0), 5.0);
  engine.hold(true);
  for (int i = 0; i < 10; ++i)
    engine.beginCycle({});
  engine.hold(false);
  engine.beginCycle({});
  EXPECT_EQ(apply(9.0), 9.0) << "not the 5 of long ago";
  EXPECT_EQ(apply(11.0), 9.0);
}

TEST(FaultHold, SoItIsForOneThatActedBeforeIt) {
  Fault frozen = stuck(FaultTrigger::kPowerOn, 1);
  frozen.kind = FaultKind::kHoldLast;
  frozen.duration_ticks = 0;
  FaultEngine engine = armed(frozen);
  const auto apply = [&](double value) { return engine.apply(FaultVariable::kDac, Arm::kGold, kShoulder, value); };
  engine.beginCycle({});
  EXPECT_EQ(apply(5.0), 5.0);
  engine.beginCycle({});
  EXPECT_EQ(apply(7.0), 5.0);
  engine.hold(true);
  engine.beginCycle({});
  engine.hold(false);
  engine.beginCycle({});
  EXPECT_EQ(apply(9.0), 9.0);
  EXPECT_EQ(apply(11.0), 9.0);
}

TEST(FaultHold, KeepsWhatWasDrawnOnce) {
  Fault drawn = stuck(FaultTrigger::kPowerOn, 0);
  drawn.kind = FaultKind::kRandomOnce;
  drawn.low = 0.0;
  drawn.high = 1.0;
  drawn.duration_ticks = 0;
  FaultEngine engine = armed(drawn);
  const auto apply = [&] { return engine.apply(FaultVariable::kDac, Arm::kGold, kShoulder, 5.0); };
  engine.beginCycle({});
  const double before = apply();
  engine.hold(true);
  engine.beginCycle({});
  engine.hold(false);
  engine.beginCycle({});
  EXPECT_EQ(apply(), before);
}

TEST(FaultHold, LetsNothingActUntilItIsOver) {
  FaultEngine engine = armed(stuck(FaultTrigger::kPowerOn, 0));
  engine.hold(true);
  engine.beginCycle({});
  EXPECT_FALSE(engine.isArmed());
  EXPECT_EQ(engine.activeMask(), 0);
  EXPECT_EQ(engine.activeId(), 0U);
  EXPECT_EQ(engine.apply(FaultVariable::kDac, Arm::kGold, kShoulder, 5.0), 5.0);
  engine.hold(false);
  engine.beginCycle({});
  EXPECT_EQ(engine.apply(FaultVariable::kDac, Arm::kGold, kShoulder, 5.0), 1.0);
  engine.hold(true);
  EXPECT_EQ(toldBy(&engine), (std::vector<int>{1, -1}));
}

TEST(FaultTriggers, ProbabilityIsThatOfEachTimeItIsDueAndOfTheSeed) {
  Fault fault = stuck(FaultTrigger::kPowerOn, 0);
  fault.period_ticks = 5;
  fault.probability = 0.3;
  const auto count = [&](std::uint64_t seed) {
    fault.seed = seed;
    return actingCycles(armed(fault), 50000, [](int) { return FaultCycle{}; });
  };
  const std::vector<int> one = count(1);
  EXPECT_EQ(one, count(1));
  EXPECT_NE(one, count(2));
  // 10,000 times due, 3 ticks each: mean 9,000, deviation 3 sqrt(10,000 0.3 0.7) = 137
  EXPECT_NEAR(static_cast<double>(one.size()), 9000.0, 4 * 137.0);
}

TEST(FaultTriggers, AHundredRandomOnesStartAndEndAtTheNamedTick) {
  Random random(7);
  for (int n = 0; n < 100; ++n) {
    Fault fault = stuck(n % 2 == 0 ? FaultTrigger::kPedalDown : FaultTrigger::kPowerOn, random.next() % 2000);
    fault.duration_ticks = 1 + random.next() % 400;
    fault.period_ticks = fault.duration_ticks + random.next() % 1000;
    fault.count = 1 + random.next() % 3;
    const int pedal_at = static_cast<int>(random.next() % 500);
    const std::vector<int> acting = actingCycles(armed(fault), 9000, [&](int i) {
      return FaultCycle{i >= pedal_at, 3, {}};
    });
    const std::int64_t zero = fault.trigger == FaultTrigger::kPedalDown ? pedal_at : 0;
    std::vector<int> expected;
    for (std::int64_t i = 0; i < fault.count; ++i) {
      for (std::int64_t k = 0; k < fault.duration_ticks; ++k)
        expected.push_back(static_cast<int>(zero + fault.first_tick + i * fault.period_ticks + k));
    }
    ASSERT_EQ(acting, expected) << n;
  }
}

TEST(FaultTriggers, OneThatCameLateDoesNotRunIntoItsNextTime) {
  Fault fault = stuck(FaultTrigger::kPedalDown, 10);
  fault.duration_ticks = 6;
  fault.period_ticks = 10;
  // Due at 10 with the pedal up until 18: it acts from 18 to 23, over its time at 20, and then at 30.
  EXPECT_EQ(actingCycles(armed(fault), 37,
                         [](int i) {
                           return FaultCycle{i < 10 || i >= 18, 3, {}};
                         }),
            (std::vector<int>{18, 19, 20, 21, 22, 23, 30, 31, 32, 33, 34, 35}));
}

TEST(FaultTriggers, UntilClearedMeansUntilCleared) {
  Fault fault = stuck(FaultTrigger::kPowerOn, 3);
  fault.duration_ticks = 0;
  EXPECT_EQ(actingCycles(armed(fault), 5000, [](int) { return FaultCycle{}; }).size(), 4997U);
}

TEST(FaultSessions, WhatStaysGoesOnWhicheverRowItBecomes) {
  Fault first = stuck(FaultTrigger::kHand, 0), second = stuck(FaultTrigger::kHand, 5);
  first.duration_ticks = 0;
  second.id = 2;
  second.duration_ticks = 10;
  FaultPlan both = planOf(first, 1, 7);
  both.count = 2;
  both.faults[1] = second;
  FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(both);
  for (int i = 0; i < 8; ++i)  // the second one acts in the last three
    engine.beginCycle({});
  engine.setPlan(planOf(second, 2, 7));
  std::vector<std::pair<std::uint32_t, int>> told;
  FaultChange change;
  while (engine.nextChange(&change))
    told.emplace_back(change.id, change.acts);
  EXPECT_EQ(told, (std::vector<std::pair<std::uint32_t, int>>{{1U, 1}, {2U, 1}, {1U, 0}}));
  EXPECT_EQ(actingCycles(engine, 20, [](int) { return FaultCycle{}; }), (std::vector<int>{0, 1, 2, 3, 4, 5, 6}));
}

TEST(FaultHold, WhatRunsOutMeanwhileHasEndedOnce) {
  for (const bool by_link : {false, true}) {
    const Fault fault = stuck(FaultTrigger::kHand, 0);  // for three cycles
    FaultEngine engine(FaultHost::kRobot);
    engine.setPlan(planOf(fault, 1, 7));
    engine.beginCycle({});
    if (by_link) engine.setPlan(suspended(2, 7));
    engine.hold(!by_link);
    for (int i = 0; i < 10; ++i)
      engine.beginCycle({});
    engine.hold(false);
    if (by_link) engine.setPlan(planOf(fault, 3, 7));
    engine.beginCycle({});
    EXPECT_EQ(engine.activeMask(), 0);
    EXPECT_EQ(toldBy(&engine), (std::vector<int>{1, -1})) << by_link;
  }
}

TEST(FaultTriggers, AStepThatIsPastHasBeenReached) {
  Fault fault = stuck(FaultTrigger::kStep, 0);
  fault.threshold = 3.0;
  for (const std::uint32_t step : {2U, 3U, 4U, 7U}) {
    const auto exercise = [step](int) {
      FaultCycle cycle;
      cycle.pedal_down = true;
      cycle.signals.step = step;
      return cycle;
    };
    EXPECT_EQ(actingCycles(armed(fault), 10, exercise), step < 3U ? std::vector<int>{} : (std::vector<int>{0, 1, 2}))
        << step;
  }
}

TEST(FaultChanges, ForWhichThereWasNoRoomAreCounted) {
  Fault fault = stuck(FaultTrigger::kPowerOn, 0);
  fault.duration_ticks = 1;
  fault.period_ticks = 2;
  FaultEngine engine = armed(fault);
  for (int i = 0; i < 101; ++i)  // 51 beginnings, 50 ends
    engine.beginCycle({});
  EXPECT_EQ(engine.changesUnreported(), 101U - 64U);
  EXPECT_EQ(toldBy(&engine).size(), 64U);
  EXPECT_EQ(engine.changesUnreported(), 101U - 64U);
}

}  // namespace
}  // namespace raven2_trainer::faults
