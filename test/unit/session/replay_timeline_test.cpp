#include "raven2_trainer/session/replay_timeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

namespace raven2_trainer::session {
namespace {

TickRecord tickAt(Tick tick, Tick session_tick = -1) {
  TickRecord record;
  record.model.tick = tick;
  record.model.session_tick = session_tick;
  record.model.time_ns = 5'000'000'000 + tick * 1'000'000;
  return record;
}

HapticRecord hapticAt(Tick tick) {
  HapticRecord record;
  record.haptic.tick = tick;
  return record;
}

ExerciseRecord eventAt(Tick tick) {
  ExerciseRecord record;
  record.tick = tick;
  return record;
}

PlanRecord planAt(Tick tick, std::uint32_t id) {
  PlanRecord record;
  record.tick = tick;
  record.result.id = id;
  return record;
}

std::vector<ReplayInstant> all(ReplayTimeline* timeline) {
  std::vector<ReplayInstant> instants;
  for (ReplayInstant instant; timeline->next(&instant);)
    instants.push_back(instant);
  return instants;
}

std::vector<Tick> ticksOf(const std::vector<ReplayInstant>& instants) {
  std::vector<Tick> ticks;
  for (const ReplayInstant& instant : instants)
    ticks.push_back(instant.tick.model.tick);
  return ticks;
}

TEST(ReplayTimeline, InstantsArePeriodsApartFromTheFirstTickOn) {
  ReplayTimeline timeline(10, -1);
  for (Tick tick = 3; tick <= 47; ++tick)
    timeline.add(tickAt(tick));
  timeline.finish();
  EXPECT_EQ(ticksOf(all(&timeline)), (std::vector<Tick>{3, 13, 23, 33, 43}));
}

TEST(ReplayTimeline, AfterAGapTheNextTickThereIsIsAnInstant) {
  ReplayTimeline timeline(10, -1);
  for (const Tick tick : {0, 5, 9, 17, 18, 26, 27, 300, 301, 311})
    timeline.add(tickAt(tick));
  timeline.finish();
  EXPECT_EQ(ticksOf(all(&timeline)), (std::vector<Tick>{0, 17, 27, 300, 311}));
}

TEST(ReplayTimeline, NothingIsGivenOutWhileABatchMayHoldMoreOfIt) {
  ReplayTimeline timeline(10, -1);
  ReplayInstant instant;
  for (Tick tick = 1; tick <= ReplayTimeline::kLongestBatch; ++tick) {
    timeline.add(tickAt(tick));
    ASSERT_FALSE(timeline.next(&instant)) << tick;
  }
  timeline.add(hapticAt(1));  // behind all of them in the file
  timeline.add(tickAt(ReplayTimeline::kLongestBatch + 1));
  ASSERT_TRUE(timeline.next(&instant));
  EXPECT_EQ(instant.tick.model.tick, 1);
  EXPECT_EQ(instant.haptic.tick, 1);
  EXPECT_FALSE(timeline.next(&instant));
}

/** The same records in any order of kinds, batch by batch, as the recorder may write them, give the same instants. */
TEST(ReplayTimeline, TheOrderOfKindsInABatchDoesNotMatter) {
  constexpr Tick kTicks = 4000;
  std::mt19937 random(7);
  const auto run = [&](bool mixed) {
    ReplayTimeline timeline(10, -1);
    std::vector<ReplayInstant> instants;
    const auto take = [&] {
      for (ReplayInstant instant; timeline.next(&instant);)
        instants.push_back(instant);
    };
    for (Tick begin = 0; begin < kTicks;) {
      const Tick end = mixed ? std::min<Tick>(kTicks, begin + 1 + static_cast<Tick>(random() % 2000)) : begin + 1;
      const bool ticks_first = mixed && random() % 2 == 0;
      for (int pass = 0; pass < 2; ++pass) {
        for (Tick tick = begin; tick < end; ++tick) {
          if ((pass == 0) == ticks_first) {
            timeline.add(tickAt(tick));
            take();
          } else {
            timeline.add(hapticAt(tick));
            if (tick % 7 == 0) timeline.add(eventAt(tick));
            if (tick % 350 == 0) timeline.add(planAt(tick, static_cast<std::uint32_t>(tick)));
            timeline.add(ContactRecord{tick, 1, 2, 1, 0.0, {}, {}});
          }
        }
      }
      begin = end;
    }
    timeline.finish();
    take();
    return instants;
  };
  const std::vector<ReplayInstant> ordered = run(false), mixed = run(true);
  ASSERT_EQ(ordered.size(), 400U);
  ASSERT_EQ(mixed.size(), ordered.size());
  std::size_t events = 0, plans = 0;
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    const ReplayInstant &a = ordered[i], &b = mixed[i];
    EXPECT_EQ(a.haptic.tick, a.tick.model.tick);
    EXPECT_EQ(b.haptic.tick, a.tick.model.tick);
    ASSERT_EQ(a.contacts.size(), 1U);
    ASSERT_EQ(b.contacts.size(), 1U);
    EXPECT_EQ(b.contacts[0].tick, a.tick.model.tick);
    EXPECT_EQ(b.events.size(), a.events.size());
    EXPECT_EQ(b.plans.size(), a.plans.size());
    events += b.events.size();
    plans += b.plans.size();
  }
  EXPECT_EQ(events, 571U) << "those of ticks 0, 7 ... 3990, all once";
  EXPECT_EQ(plans, 12U) << "0, 350 ... 3850";
}

TEST(ReplayTimeline, WhatIsNewIsInTheFirstInstantThatIsNoOlder) {
  ReplayTimeline timeline(10, -1);
  for (Tick tick = 0; tick <= 30; ++tick)
    timeline.add(tickAt(tick));
  for (const Tick tick : {0, 1, 10, 11, 29})
    timeline.add(eventAt(tick));
  timeline.add(planAt(11, 4));
  timeline.add(planAt(20, 5));
  timeline.finish();
  const std::vector<ReplayInstant> instants = all(&timeline);
  ASSERT_EQ(instants.size(), 4U);
  EXPECT_EQ(instants[0].events.size(), 1U);
  EXPECT_EQ(instants[1].events.size(), 2U);
  EXPECT_EQ(instants[2].events.size(), 1U);
  EXPECT_EQ(instants[3].events.size(), 1U);
  ASSERT_EQ(instants[2].plans.size(), 2U);
  EXPECT_EQ(instants[2].plans[0].id, 4U);
  EXPECT_EQ(instants[2].plans[1].id, 5U);
  EXPECT_EQ(instants[0].haptic.tick, -1) << "no haptic record yet";
}

TEST(ReplayTimeline, BegunLaterItKnowsThePlanOfBeforeAndTellsNoOldEvents) {
  ReplayTimeline timeline(10, 3000);
  for (Tick tick = 0; tick <= 5020; ++tick) {
    timeline.add(hapticAt(tick));
    if (tick == 100) timeline.add(planAt(tick, 9));
    if (tick == 100 || tick == 3999 || tick == 4000 || tick == 4005) timeline.add(eventAt(tick));
    timeline.add(tickAt(tick, tick - 1000));
  }
  timeline.finish();
  const std::vector<ReplayInstant> instants = all(&timeline);
  ASSERT_EQ(instants.size(), 103U);
  EXPECT_EQ(instants[0].tick.model.tick, 4000);
  EXPECT_EQ(instants[0].haptic.tick, 4000);
  ASSERT_EQ(instants[0].plans.size(), 1U);
  EXPECT_EQ(instants[0].plans[0].id, 9U);
  ASSERT_EQ(instants[0].events.size(), 1U);
  EXPECT_EQ(instants[0].events[0].tick, 4000);
  EXPECT_EQ(instants[1].events.size(), 1U);
}

/** A tick with a valid CRC may still be out of order or have an impossible time. */
TEST(ReplayTimeline, TicksThatCannotFollowAreLeftOut) {
  ReplayTimeline timeline(1, -1);
  timeline.add(tickAt(5));
  timeline.add(tickAt(5));
  timeline.add(tickAt(4));
  TickRecord odd = tickAt(6);
  odd.model.time_ns = tickAt(5).model.time_ns;
  timeline.add(odd);
  odd.model.time_ns = std::numeric_limits<std::int64_t>::max();
  timeline.add(odd);
  timeline.add(tickAt(7));
  timeline.finish();
  EXPECT_EQ(ticksOf(all(&timeline)), (std::vector<Tick>{5, 7}));

  ReplayTimeline no_time(1, -1);
  odd.model.time_ns = 0;  // ROS takes 0 for "no clock yet"
  no_time.add(odd);
  no_time.finish();
  EXPECT_TRUE(all(&no_time).empty());
}

TEST(ReplayTimeline, APeriodOfNothingIsRefused) {
  EXPECT_THROW(ReplayTimeline(0, -1), std::invalid_argument);
}

ExecutionRecord executionAt(Tick tick, std::uint32_t plan) {
  ExecutionRecord record;
  record.tick = tick;
  record.report.plan = plan;
  return record;
}

TEST(ReplayTimeline, ExecutionsAreInTheFirstInstantThatIsNoOlderEachOnce) {
  ReplayTimeline timeline(10, -1);
  for (const auto& [tick, plan] : {std::pair<Tick, std::uint32_t>{0, 1}, {10, 2}, {11, 3}, {19, 4}})
    timeline.add(executionAt(tick, plan));
  for (Tick tick = 0; tick <= 30; ++tick)
    timeline.add(tickAt(tick));
  timeline.finish();
  std::vector<std::vector<std::uint32_t>> plans;
  for (const ReplayInstant& instant : all(&timeline)) {
    plans.emplace_back();
    for (const ExecutionReport& report : instant.executions)
      plans.back().push_back(report.plan);
  }
  EXPECT_EQ(plans, (std::vector<std::vector<std::uint32_t>>{{1}, {2}, {3, 4}, {}}));
}

TEST(ReplayTimeline, TheNewestHapticStateIsKnownUntilThereIsANewerOne) {
  ReplayTimeline timeline(10, -1);
  for (const Tick tick : {3, 25, 31})
    timeline.add(hapticAt(tick));
  for (Tick tick = 0; tick <= 40; ++tick)
    timeline.add(tickAt(tick));
  timeline.finish();
  std::vector<Tick> known;
  for (const ReplayInstant& instant : all(&timeline))
    known.push_back(instant.haptic.tick);
  EXPECT_EQ(known, (std::vector<Tick>{-1, 3, 3, 25, 31}));
}

TEST(ReplayTimeline, BegunLaterItKnowsTheHapticStateOfBefore) {
  ReplayTimeline timeline(10, 9000);
  timeline.add(hapticAt(3));
  for (Tick tick = 0; tick <= 9000; ++tick)
    timeline.add(tickAt(tick, tick));
  timeline.finish();
  const std::vector<ReplayInstant> instants = all(&timeline);
  ASSERT_EQ(ticksOf(instants), (std::vector<Tick>{9000}));
  EXPECT_EQ(instants[0].haptic.tick, 3);
}

TEST(ReplayTimeline, ContactsAreThoseOfTheInstantsTickAlone) {
  ReplayTimeline timeline(10, -1);
  for (const Tick tick : {0, 9, 10, 10, 11})
    timeline.add(ContactRecord{tick, 1, 2, 1, 0.0, {}, {}});
  for (Tick tick = 0; tick <= 20; ++tick)
    timeline.add(tickAt(tick));
  timeline.finish();
  std::vector<std::size_t> counts;
  for (const ReplayInstant& instant : all(&timeline))
    counts.push_back(instant.contacts.size());
  EXPECT_EQ(counts, (std::vector<std::size_t>{1, 2, 0}));
}

}  // namespace
}  // namespace raven2_trainer::session
