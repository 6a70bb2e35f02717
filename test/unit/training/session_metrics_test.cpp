#include "raven2_trainer/training/session_metrics.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "gtest/gtest.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/scratch_path.h"

namespace raven2_trainer::training {
namespace {

using raven2_trainer::testing::scratchPath;

constexpr double kMillimetre = 0.001;
constexpr Tick kOrigin = 5000;  // model tick of the first pedal down

session::LogHeader makeHeader() {
  session::LogHeader header;
  header.scenarios = {"other", "sudden_jump"};
  header.tolerance = 3 * kMillimetre;
  return header;
}

/** A tick of teleoperation whose gold tips are `error` [m] apart. */
TickRecord makeTick(Tick session_tick, double error, std::uint32_t fault = 0) {
  TickRecord record;
  record.model.session_tick = session_tick;
  record.model.tick = kOrigin + session_tick;
  record.model.mode = Mode::kTeleoperating;
  record.model.robot_fresh = 1;
  record.model.linked = 1;
  record.robot.frame = 1;
  record.robot.connected = 1;
  record.robot.cycle = 70000 + static_cast<std::uint64_t>(session_tick);
  record.robot.active_fault = fault;
  at(record.model.arms, Arm::kGold).p_BT = {0.1, 0.2 + error, 0.3};
  at(record.robot.arms, Arm::kGold).p_BT = {0.1, 0.2, 0.3};
  return record;
}

HapticRecord makeForce(Tick session_tick, double newton, double error = 0.0) {
  HapticRecord record;
  record.haptic.tick = kOrigin + session_tick;
  record.haptic.active = 1;
  record.haptic.error = {error, 0.5 * error};
  at(record.haptic.force_B, Arm::kGreen) = {0.6 * newton, 0.0, -0.8 * newton};
  return record;
}

FaultChangeRecord makeChange(const TickRecord& record, std::uint32_t id, bool acts, std::uint8_t row = 0) {
  FaultChangeRecord change;
  change.tick = record.model.tick;
  change.change.cycle = record.robot.cycle;
  change.change.id = id;
  change.change.row = row;
  change.change.acts = acts ? 1 : 0;
  return change;
}

double goldError(const TickRecord& record) {
  return at(record.model.arms, Arm::kGold).p_BT[1] - at(record.robot.arms, Arm::kGold).p_BT[1] +
         at(record.model.arms, Arm::kGold).p_BT[0] - at(record.robot.arms, Arm::kGold).p_BT[0];
}

/** Adds the beginnings and ends that the ticks' active_fault implies, and the haptic record of each tick's distance. */
class Accumulator : public MetricsAccumulator {
 public:
  using MetricsAccumulator::add;
  using MetricsAccumulator::MetricsAccumulator;
  void add(const TickRecord& record) {
    const std::uint32_t acts = record.robot.active_fault;
    if (acts != acted_ && acted_ != 0) add(makeChange(record, acted_, false));
    if (acts != acted_ && acts != 0) add(makeChange(record, acts, true));
    acted_ = acts;
    MetricsAccumulator::add(record);
    if (!feels) return;
    HapticRecord haptic = makeForce(record.model.session_tick, 0.0, goldError(record));
    haptic.haptic.tick = record.model.tick;
    haptic.haptic.active = record.model.linked != 0 && record.model.robot_fresh != 0 ? 1 : 0;
    add(haptic);
  }

  bool feels{true};  ///< false: the test feeds the haptic records, errors and all

 private:
  std::uint32_t acted_{0};
};

/** Feeds ticks first..last with the same error and fault. */
void feed(Accumulator* metrics, Tick first, Tick last, double error, std::uint32_t fault = 0) {
  for (Tick t = first; t <= last; ++t)
    metrics->add(makeTick(t, error, fault));
}

TEST(RunningStats, MatchesMeanAndSampleDeviationByHand) {
  RunningStats stats;
  for (const double x : {2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0})
    stats.add(x);
  EXPECT_EQ(stats.count(), 8u);
  EXPECT_DOUBLE_EQ(stats.mean(), 5.0);
  EXPECT_DOUBLE_EQ(stats.deviation(), std::sqrt(32.0 / 7.0));  // squares: 9+1+1+1+0+0+4+16
  EXPECT_EQ(stats.max(), 9.0);
}

TEST(RunningStats, HasNoDeviationBelowTwoValues) {
  RunningStats stats;
  EXPECT_EQ(stats.deviation(), 0.0);
  stats.add(-3.0);
  EXPECT_EQ(stats.deviation(), 0.0);
  EXPECT_EQ(stats.max(), -3.0);
}

TEST(RunningStats, KeepsSmallDeviationsOnALargeMean) {
  RunningStats stats;
  for (int i = 0; i < 1000; ++i)
    stats.add(1e9 + (i % 2));  // a sum of squares would lose this
  EXPECT_NEAR(stats.deviation(), 0.5 * std::sqrt(1000.0 / 999.0), 1e-6);
}

/** A tick of executing a plan. */
TickRecord makeExecutingTick(Tick session_tick) {
  TickRecord record = makeTick(session_tick, 0.0);
  record.model.mode = Mode::kExecuting;
  record.model.planning.status = PlanningStatus::kExecuting;
  return record;
}

ExecutionRecord makeExecution(Tick started, Tick ended) {
  ExecutionRecord record;
  record.tick = ended;
  record.report.plan = 7;
  record.report.arm = Arm::kGreen;
  record.report.on_robot = 1;
  record.report.end = started < 0 ? ExecutionEnd::kNoPedal : ExecutionEnd::kReleased;
  record.report.started = started;
  record.report.ended = ended;
  record.report.path_time = 2.5;
  record.report.progress = started < 0 ? 0.0 : 0.4;
  record.report.model = {0.0005, 0.002, 0.011};
  record.report.robot = {0.001, 0.003, 0.012};
  record.report.contact_ticks = 3;
  return record;
}

TEST(SessionMetrics, AnExecutionBeginsInTheSessionTickOfItsPedalDown) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 99, 0.0);
  metrics.add(makeExecution(kOrigin + 100, kOrigin + 350));  // the queues are written one after the other
  for (Tick t = 100; t < 350; ++t)
    metrics.add(makeExecutingTick(t));
  feed(&metrics, 350, 399, 0.0);
  for (Tick t = 400; t < 1000; ++t) {  // the session's clock stopped for 150 ms before this tick
    TickRecord tick = makeExecutingTick(t);
    tick.model.tick += 150;
    metrics.add(tick);
  }
  metrics.add(makeExecution(kOrigin + 550, kOrigin + 1150));
  metrics.add(makeExecution(-1, kOrigin + 1500));
  const std::vector<Execution> executions = metrics.result().executions;
  ASSERT_EQ(executions.size(), 3u);
  EXPECT_EQ(executions[0].start_tick, 100);
  EXPECT_EQ(executions[1].start_tick, 400);
  EXPECT_EQ(executions[2].start_tick, -1) << "the pedal never came";
}

TEST(SessionMetrics, AnExecutionWhoseTicksAreMissingHasNoBeginning) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 99, 0.0);
  metrics.add(makeExecution(kOrigin + 100, kOrigin + 350));
  feed(&metrics, 350, 399, 0.0);
  metrics.add(makeExecutingTick(400));
  ASSERT_EQ(metrics.result().executions.size(), 1u);
  EXPECT_EQ(metrics.result().executions[0].start_tick, -1);
  EXPECT_TRUE(Accumulator(makeHeader()).result().executions.empty());
}

TEST(SessionMetrics, TimeStartsAtTheFirstPedalDown) {
  Accumulator metrics(makeHeader());
  TickRecord before = makeTick(-1, 0.5);  // half a metre, but not of the session
  before.model.tick = 3;
  metrics.add(before);
  feed(&metrics, 0, 1999, 0.001);
  const SessionMetrics result = metrics.result();
  EXPECT_EQ(result.ticks, 2000u);
  EXPECT_DOUBLE_EQ(result.duration, 2.0);
  EXPECT_EQ(result.error.count(), 2000u);
  EXPECT_NEAR(result.error.max(), 0.001, 1e-15);
}

TEST(SessionMetrics, TakesTheLargerArmsError) {
  Accumulator metrics(makeHeader());
  TickRecord record = makeTick(0, 0.001);
  at(record.model.arms, Arm::kGreen).p_BT = {0.0, 0.003, 0.004};
  metrics.add(record);
  metrics.add(makeTick(1, 0.001));
  EXPECT_NEAR(metrics.result().error.mean(), 0.003, 1e-15);  // (5 + 1) / 2 mm
  EXPECT_NEAR(metrics.result().error.deviation(), 0.004 / std::sqrt(2.0), 1e-15);
}

TEST(SessionMetrics, LeavesOutWhatCannotBeCompared) {
  Accumulator metrics(makeHeader());
  for (int what = 0; what < 4; ++what) {
    TickRecord record = makeTick(what, 0.5);
    if (what == 0) record.model.mode = Mode::kTracking;
    if (what == 1) record.model.robot_fresh = 0;
    if (what == 2) record.model.linked = 0;
    if (what == 3) record.robot.frame = 0;
    metrics.add(record);
  }
  EXPECT_EQ(metrics.result().error.count(), 0u);
  EXPECT_EQ(metrics.result().ticks, 4u);
}

TEST(FaultEvent, HasKnownTicksOnBothClocksAndKnownOnset) {
  Accumulator metrics(makeHeader());
  for (Tick t = 0; t < 3000; ++t) {
    const bool acting = t >= 1000 && t <= 1299;
    const double error = t >= 1040 && t <= 1400 ? 0.012 : 0.001;
    metrics.add(makeTick(t, error, acting ? 2 : 0));
    metrics.add(makeForce(t, t >= 1045 && t <= 1400 ? 2.5 : 0.0));
  }
  const SessionMetrics result = metrics.result();
  ASSERT_EQ(result.faults.size(), 1u);
  const FaultEvent& event = result.faults[0];
  EXPECT_EQ(event.name, "sudden_jump");
  EXPECT_EQ(event.first_tick, 1000);
  EXPECT_EQ(event.last_tick, 1299);
  EXPECT_EQ(event.first_cycle, 71000u);
  EXPECT_EQ(event.last_cycle, 71299u);
  EXPECT_NEAR(event.max_error, 0.012, 1e-15);
  EXPECT_EQ(event.onset_tick, 1040);
  EXPECT_EQ(event.force_tick, 1045);
  EXPECT_EQ(event.errorToForce(), 5);
  EXPECT_NEAR(event.max_force, 2.5, 1e-15);
  // the error is calm from tick 1401; the 500th calm tick is 1900
  EXPECT_EQ(event.end_tick, 1900);
  EXPECT_EQ(result.error.count(), 3000u - 901u);
  EXPECT_NEAR(result.error.max(), 0.001, 1e-15);
  EXPECT_EQ(result.error_max_force, 0.0);
}

TEST(FaultEvent, IsTheSameWhereverTheHapticRecordsStand) {
  // GIVEN one stream fed tick by tick, one with the forces a block of 50 ticks late, one with them early
  std::vector<SessionMetrics> results;
  for (const Tick shift : {0, 50, -50}) {
    Accumulator metrics(makeHeader());
    metrics.feels = false;
    for (Tick t = -60; t < 3060; ++t) {
      if (t >= 0 && t < 3000) {
        const double error = t >= 1040 && t <= 1400 ? 0.012 : 0.001;
        metrics.add(makeTick(t, error, t >= 1000 && t <= 1299 ? 2 : 0));
      }
      const Tick force_tick = t - shift;
      if (force_tick < 0 || force_tick >= 3000) continue;
      const double outside = force_tick == 999 || force_tick == 1901 ? 0.5 : 0.0;
      const double error = force_tick >= 1040 && force_tick <= 1400 ? 0.012 : 0.001;
      metrics.add(makeForce(force_tick, force_tick >= 1045 && force_tick <= 1900 ? 2.5 : outside, error));
    }
    results.push_back(metrics.result());
  }
  for (const SessionMetrics& result : results) {
    ASSERT_EQ(result.faults.size(), 1u);
    EXPECT_EQ(result.faults[0].force_tick, 1045);
    EXPECT_NEAR(result.faults[0].max_force, 2.5, 1e-15);
    EXPECT_NEAR(result.error_max_force, 0.5, 1e-15);
    EXPECT_NEAR(result.max_force, 2.5, 1e-15);
  }
}

TEST(FaultEvent, ForceBeforeTheErrorIsNoReaction) {
  Accumulator metrics(makeHeader());
  for (Tick t = 0; t < 200; ++t) {
    metrics.add(makeTick(t, t >= 150 ? 0.004 : 0.0, 1));
    metrics.add(makeForce(t, t == 100 || t >= 150 ? 1.0 : 0.0));
  }
  const FaultEvent event = metrics.result().faults.at(0);
  EXPECT_EQ(event.force_tick, 150);
  EXPECT_EQ(event.errorToForce(), 0);
}

TEST(FaultEvent, WithoutErrorOrForceSaysNever) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 99, 0.001, 1);
  feed(&metrics, 100, 999, 0.001);
  const FaultEvent event = metrics.result().faults.at(0);
  EXPECT_EQ(event.onset_tick, -1);
  EXPECT_EQ(event.force_tick, -1);
  EXPECT_EQ(event.errorToForce(), -1);
  EXPECT_EQ(event.end_tick, 599);
}

TEST(FaultEvent, AtTheToleranceExactlyIsNotBeyondIt) {
  session::LogHeader header = makeHeader();
  header.tolerance = 0.25;  // exact in binary, as the positions below
  Accumulator metrics(header);
  TickRecord record = makeTick(0, 0.0, 1);
  at(record.model.arms, Arm::kGold).p_BT = {0.5, 0.0, 0.0};
  at(record.robot.arms, Arm::kGold).p_BT = {0.25, 0.0, 0.0};
  metrics.add(record);
  EXPECT_EQ(metrics.result().faults.at(0).onset_tick, -1);
}

TEST(FaultAftermath, StartsAnewWhenTheErrorComesBack) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 9, 0.010, 2);
  feed(&metrics, 10, 508, 0.0);  // 499 calm ticks: one short
  feed(&metrics, 509, 509, 0.004);
  feed(&metrics, 510, 1008, 0.002);
  EXPECT_EQ(metrics.result().faults.at(0).end_tick, -1);
  EXPECT_EQ(metrics.result().error.count(), 0u);
  feed(&metrics, 1009, 1010, 0.002);
  EXPECT_EQ(metrics.result().faults.at(0).end_tick, 1009);
  EXPECT_EQ(metrics.result().error.count(), 1u);
}

TEST(FaultAftermath, DoesNotEndWhileTheRobotIsUnknown) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 9, 0.010, 2);
  for (Tick t = 10; t < 2000; ++t) {
    TickRecord stale = makeTick(t, 0.0);
    stale.model.robot_fresh = 0;
    metrics.add(stale);
  }
  EXPECT_EQ(metrics.result().faults.at(0).end_tick, -1);
}

TEST(FaultAftermath, RunsOutWhileThePedalIsUp) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 9, 0.010, 2);
  for (Tick t = 10; t < 1000; ++t) {
    TickRecord up = makeTick(t, 0.010);
    up.model.mode = Mode::kPedalUp;
    up.model.linked = 0;
    metrics.add(up);
  }
  const FaultEvent event = metrics.result().faults.at(0);
  EXPECT_EQ(event.end_tick, 509);
  EXPECT_NEAR(event.max_error, 0.010, 1e-15);
}

TEST(FaultAftermath, EndsWhereTheNextFaultBegins) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 9, 0.010, 2);
  feed(&metrics, 10, 99, 0.010);
  feed(&metrics, 100, 109, 0.020, 2);
  feed(&metrics, 110, 119, 0.030, 1);  // another scenario, with no gap
  const SessionMetrics result = metrics.result();
  ASSERT_EQ(result.faults.size(), 3u);
  EXPECT_EQ(result.faults[0].end_tick, 99);
  EXPECT_EQ(result.faults[1].first_tick, 100);
  EXPECT_EQ(result.faults[1].last_tick, 109);
  EXPECT_NEAR(result.faults[1].max_error, 0.020, 1e-15);
  EXPECT_EQ(result.faults[2].name, "other");
  EXPECT_EQ(result.faults[2].onset_tick, 110);
}

TEST(FaultEvent, OfAScenarioTheLogDoesNotNameGetsItsNumber) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 1, 0.0, 7);
  EXPECT_EQ(metrics.result().faults.at(0).name, "fault_7");
}

FaultRecord makePlan(Tick session_tick, std::uint32_t id, std::size_t rows) {
  FaultRecord record;
  record.tick = kOrigin + session_tick;
  record.plan.count = static_cast<std::uint32_t>(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    record.plan.faults[i].id = id;
    record.plan.faults[i].row = static_cast<std::uint8_t>(i);
    record.plan.faults[i].value = 100.0 * static_cast<double>(i + 1);
  }
  return record;
}

TEST(Injections, KnowAFaultOfOneCycleThatNoStateShowed) {
  MetricsAccumulator metrics(makeHeader());
  metrics.add(makePlan(0, 2, 2));
  for (Tick t = 0; t < 700; ++t) {
    TickRecord record = makeTick(t, t < 20 ? 0.0 : 0.001);
    if (t == 10) {  // began and ended between two ticks of ours
      FaultChangeRecord change = makeChange(record, 2, true, 1);
      change.change.cycle = 70006;
      metrics.add(change);
      change.change.acts = 0;
      change.change.cycle = 70007;
      metrics.add(change);
    }
    metrics.add(record);
  }
  const SessionMetrics result = metrics.result();
  ASSERT_EQ(result.injections.size(), 1U);
  const Injection& injection = result.injections[0];
  EXPECT_EQ(injection.name, "sudden_jump");
  EXPECT_EQ(injection.fault.value, 200.0) << "the row's own";
  EXPECT_EQ(injection.inject_tick, 10);
  EXPECT_EQ(injection.clear_tick, 10);
  EXPECT_EQ(injection.inject_cycle, 70006U);
  EXPECT_EQ(injection.clear_cycle, 70007U);
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_EQ(result.faults[0].first_tick, 10);
  EXPECT_EQ(result.faults[0].last_tick, 10);
}

TEST(Injections, KeepTheirRowsWhenThePlanChangesWhileTheyAct) {
  MetricsAccumulator metrics(makeHeader());
  FaultRecord both = makePlan(0, 1, 1);
  both.plan.faults[both.plan.count++] = makePlan(0, 2, 1).plan.faults[0];
  metrics.add(both);
  TickRecord record = makeTick(0, 0.0);
  metrics.add(makeChange(record, 1, true));
  metrics.add(makeChange(record, 2, true));
  metrics.add(record);
  metrics.add(makePlan(5, 2, 1));  // the first is cleared, the second moves up
  record = makeTick(5, 0.0);
  metrics.add(makeChange(record, 1, false));
  metrics.add(record);
  metrics.add(makeTick(6, 0.0));
  const std::vector<Injection> all = metrics.result().injections;
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].name, "other");
  EXPECT_EQ(all[0].clear_tick, 5);
  EXPECT_EQ(all[1].name, "sudden_jump");
  EXPECT_EQ(all[1].clear_tick, -1);
}

TEST(Injections, EndWithTheLink) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 9, 0.0, 2);
  TickRecord lost = makeTick(10, 0.0, 2);
  lost.robot.connected = 0;
  lost.robot.cycle = 70009;
  metrics.add(lost);
  Injection injection = metrics.result().injections.at(0);
  EXPECT_EQ(injection.clear_tick, 10);
  EXPECT_EQ(injection.clear_cycle, 70009U);
  EXPECT_TRUE(injection.is_assumed);
  // The robot is back and reports the true end.
  TickRecord back = makeTick(900, 0.0);
  FaultChangeRecord end = makeChange(back, 2, false);
  end.change.cycle = 70700;
  metrics.add(end);
  static_cast<MetricsAccumulator&>(metrics).add(back);
  injection = metrics.result().injections.at(0);
  EXPECT_EQ(injection.clear_tick, 900);
  EXPECT_EQ(injection.clear_cycle, 70700U);
  EXPECT_FALSE(injection.is_assumed);
}

TEST(Injections, OfBeforeThePedalKnowTheCrossingAfterIt) {
  Accumulator metrics(makeHeader());
  TickRecord before = makeTick(-1, 0.0, 2);
  metrics.add(before);
  feed(&metrics, 0, 99, 0.001, 2);
  feed(&metrics, 100, 199, 0.005, 2);
  const Injection injection = metrics.result().injections.at(0);
  EXPECT_EQ(injection.inject_tick, -1);
  EXPECT_EQ(injection.observe_tick, 100);
}

TEST(Injections, AHundredThousandAreListedAndTheRestCounted) {
  MetricsAccumulator metrics(makeHeader());
  TickRecord record = makeTick(0, 0.0);
  for (std::uint64_t i = 0; i < kMaxInjections + 5; ++i) {
    record.model.tick = kOrigin + static_cast<Tick>(i);
    record.model.session_tick = static_cast<Tick>(i);
    metrics.add(makeChange(record, 2, true));
    metrics.add(makeChange(record, 2, false));
    metrics.add(record);
  }
  const SessionMetrics result = metrics.result();
  EXPECT_EQ(result.injections.size(), kMaxInjections);
  EXPECT_EQ(result.injections_beyond, 5U);
}

TEST(SessionMetrics, SumsAFourJumpSession) {
  // GIVEN the paper's pattern: 300 ms every 8 s, four times in 34 s, and forces outside them
  Accumulator metrics(makeHeader());
  for (Tick t = 0; t < 34000; ++t) {
    const Tick phase = t % 8000;
    const bool acting = t >= 8000 && phase < 300;
    const double height = 0.005 * static_cast<double>(t / 8000);
    metrics.add(makeTick(t, acting && phase >= 20 ? height : 0.002, acting ? 2 : 0));
    metrics.add(makeForce(t, acting && phase >= 20 ? height * 200 : (phase == 7000 ? 0.75 : 0.0)));
  }
  const SessionMetrics result = metrics.result();
  ASSERT_EQ(result.faults.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto first = static_cast<Tick>(8000 * (i + 1));
    EXPECT_EQ(result.faults[i].first_tick, first);
    EXPECT_EQ(result.faults[i].last_tick, first + 299);
    EXPECT_EQ(result.faults[i].onset_tick, first + 20);
    EXPECT_EQ(result.faults[i].errorToForce(), 0);
    EXPECT_EQ(result.faults[i].end_tick, first + 799);
    EXPECT_NEAR(result.faults[i].max_error, 0.005 * static_cast<double>(i + 1), 1e-12);
    EXPECT_NEAR(result.faults[i].max_force, static_cast<double>(i + 1), 1e-12);
  }
  EXPECT_EQ(result.error.count(), 34000u - 4u * 800u);
  EXPECT_NEAR(result.error.mean(), 0.002, 1e-12);
  EXPECT_NEAR(result.error.deviation(), 0.0, 1e-12);
  EXPECT_NEAR(result.max_force, 4.0, 1e-12);
  EXPECT_NEAR(result.error_max_force, 0.75, 1e-12);
}

TEST(SessionMetrics, KeepsTheNewestPlan) {
  Accumulator metrics(makeHeader());
  EXPECT_EQ(metrics.result().plan.status, PlanStatus::kNone);
  PlanRecord record;
  record.result.status = PlanStatus::kNoPath;
  metrics.add(record);
  record.result.status = PlanStatus::kSuccess;
  record.result.cost = 6.5;
  metrics.add(record);
  EXPECT_EQ(metrics.result().plan.status, PlanStatus::kSuccess);
  EXPECT_EQ(metrics.result().plan.cost, 6.5);
}

TEST(SessionMetrics, KeepsEveryExecution) {
  Accumulator metrics(makeHeader());
  EXPECT_TRUE(metrics.result().executions.empty());
  metrics.add(makeExecution(5000, 6200));
  metrics.add(makeExecution(-1, 9000));
  const SessionMetrics result = metrics.result();
  ASSERT_EQ(result.executions.size(), 2U);
  EXPECT_EQ(result.executions[0].report.ended, 6200);
  EXPECT_EQ(result.executions[1].report.end, ExecutionEnd::kNoPedal);
  EXPECT_EQ(result.executions_beyond, 0U);
}

TEST(SessionMetrics, CountsExecutionsBeyondTheLongestList) {
  Accumulator metrics(makeHeader());
  for (std::size_t i = 0; i < kMaxExecutions + 5; ++i)
    metrics.add(makeExecution(-1, static_cast<Tick>(i)));
  EXPECT_EQ(metrics.result().executions.size(), kMaxExecutions);
  EXPECT_EQ(metrics.result().executions_beyond, 5U);
}

nlohmann::json readJson(const std::string& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

SessionMetrics makeResult() {
  SessionMetrics result;
  result.duration = 34.0;
  result.ticks = 34000;
  result.tolerance = 0.003;
  result.max_force = 2.5;
  result.error_max_force = 0.5;
  result.error.add(0.001);
  result.error.add(0.003);
  FaultEvent event;
  event.name = "sudden_jump";
  event.first_tick = 8000;
  event.last_tick = 8299;
  event.first_cycle = 12001;
  event.last_cycle = 12300;
  event.max_error = 0.0125;
  event.max_force = 2.5;
  event.onset_tick = 8030;
  event.force_tick = 8032;
  result.faults = {event};
  result.executions = {{makeExecution(5000, 6200).report, 4000}, {makeExecution(-1, 9000).report, -1}};
  result.counts.master.received = 100;
  result.counts.master.applied = 97;
  result.counts.master.rejected[static_cast<std::size_t>(Reject::kDuplicate)] = 3;
  result.counts.master_used = 90;
  result.counts.master_overruled = 5;
  result.counts.servo_made = 12;
  result.counts.relay_sent = 88;
  result.counts.relay.received = 87;
  result.counts.relay.applied = 87;
  result.counts.robot_state.received = 50;
  result.counts.robot_state.applied = 50;
  result.counts.force_sent = 70;
  LoopTiming& physics = result.counts.loops[0];
  physics.ticks = 1000;
  physics.on_time = 990;
  physics.slips = 10;
  physics.time_slips = 1;
  physics.lost_ticks = 260;
  physics.max_late_ns = 1500;
  physics.max_run_ns = 2500;
  physics.stale_reads = 4;
  result.counts.frames = 12;
  result.counts.realtime = 1;
  return result;
}

TEST(MetricsFile, HoldsEveryFigure) {
  const std::string path = scratchPath("metrics.json");
  writeMetrics(path, makeResult());
  const auto json = readJson(path);
  EXPECT_EQ(json.at("duration_s"), 34.0);
  EXPECT_EQ(json.at("ticks"), 34000);
  EXPECT_EQ(json.at("on_time_ratio").at("physics"), 0.99);
  EXPECT_TRUE(json.at("on_time_ratio").at("haptic").is_null()) << "no haptic tick ran";
  const auto& master = json.at("packets").at("master_to_daemon");
  EXPECT_EQ(master.at("received"), 100);
  EXPECT_EQ(master.at("applied"), 97);
  EXPECT_EQ(master.at("used"), 90);
  EXPECT_EQ(master.at("overruled"), 5);
  EXPECT_EQ(master.at("made_of_clients"), 12);
  EXPECT_EQ(master.at("rejected").at("duplicate"), 3);
  EXPECT_EQ(master.at("rejected").size(), kRejectCount - 1) << "all reasons but none";
  EXPECT_EQ(json.at("packets").at("daemon_to_robot").at("sent"), 88);
  EXPECT_EQ(json.at("packets").at("daemon_to_robot").at("received"), 87);
  EXPECT_EQ(json.at("packets").at("robot_to_daemon").at("applied"), 50);
  EXPECT_EQ(json.at("packets").at("daemon_to_console").at("sent"), 70);
  EXPECT_DOUBLE_EQ(json.at("model_robot_error_mm").at("mean"), 2.0);
  EXPECT_DOUBLE_EQ(json.at("model_robot_error_mm").at("std"), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(json.at("model_robot_error_mm").at("max"), 3.0);
  const auto& fault = json.at("faults").at(0);
  EXPECT_EQ(fault.at("name"), "sudden_jump");
  EXPECT_EQ(fault.at("first_tick"), 8000);
  EXPECT_EQ(fault.at("last_tick"), 8299);
  EXPECT_DOUBLE_EQ(fault.at("max_error_mm"), 12.5);
  EXPECT_EQ(fault.at("error_to_force_ms"), 2);
  EXPECT_EQ(fault.at("max_force_N"), 2.5);
  EXPECT_EQ(fault.at("first_cycle"), 12001);
  EXPECT_EQ(fault.at("last_cycle"), 12300);
  EXPECT_EQ(json.at("haptic").at("max_force_N"), 2.5);
  EXPECT_EQ(json.at("haptic").at("max_force_outside_faults_N"), 0.5);
  EXPECT_DOUBLE_EQ(json.at("haptic").at("threshold_mm"), 3.0);
  EXPECT_EQ(json.at("plan").at("success"), false);
  EXPECT_EQ(json.at("plan").at("status"), "none");
  const auto& execution = json.at("executions").at(0);
  EXPECT_EQ(execution.at("plan"), 7);
  EXPECT_EQ(execution.at("arm"), "green");
  EXPECT_EQ(execution.at("on_robot"), true);
  EXPECT_EQ(execution.at("end"), "released");
  EXPECT_EQ(execution.at("start_tick"), 4000);
  EXPECT_TRUE(json.at("executions").at(1).at("start_tick").is_null());
  EXPECT_DOUBLE_EQ(execution.at("duration_s"), 1.2);
  EXPECT_EQ(execution.at("progress"), 0.4);
  EXPECT_DOUBLE_EQ(execution.at("model_error_mm").at("max"), 2.0);
  EXPECT_DOUBLE_EQ(execution.at("robot_error_mm").at("at_end"), 12.0);
  EXPECT_EQ(execution.at("contact_ticks"), 3);
  EXPECT_EQ(json.at("executions").at(1).at("end"), "no_pedal");
  EXPECT_TRUE(json.at("executions").at(1).at("duration_s").is_null());
  EXPECT_TRUE(json.at("executions").at(1).at("model_error_mm").is_null());
  EXPECT_EQ(json.at("frames"), 0);
  EXPECT_EQ(json.at("live_frames"), 12);
  const auto& timing = json.at("timing").at("physics");
  EXPECT_EQ(timing.at("slips"), 10);
  EXPECT_EQ(timing.at("time_slips"), 1);
  EXPECT_EQ(timing.at("lost_ticks"), 260);
  EXPECT_EQ(timing.at("max_late_us"), 1.5);
  EXPECT_EQ(timing.at("max_run_us"), 2.5);
  EXPECT_EQ(timing.at("stale_reads"), 4);
  EXPECT_EQ(json.at("records_dropped"), 0);
  EXPECT_EQ(json.at("realtime"), true);
}

TEST(MetricsFile, HasNoOnTimeRatioInLockstep) {
  SessionMetrics result = makeResult();
  result.counts.lockstep = 1;
  writeMetrics(scratchPath("lockstep.json"), result);
  EXPECT_TRUE(readJson(scratchPath("lockstep.json")).at("on_time_ratio").at("physics").is_null());
}

TEST(MetricsFile, SaysNullForAForceThatNeverCame) {
  SessionMetrics result = makeResult();
  result.faults[0].force_tick = -1;
  writeMetrics(scratchPath("never.json"), result);
  EXPECT_TRUE(readJson(scratchPath("never.json")).at("faults").at(0).at("error_to_force_ms").is_null());
}

TEST(MetricsFile, IsTheSameBytesForTheSameMetrics) {
  writeMetrics(scratchPath("one.json"), makeResult());
  writeMetrics(scratchPath("two.json"), makeResult());
  std::ifstream one(scratchPath("one.json")), two(scratchPath("two.json"));
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(one), {}), std::string(std::istreambuf_iterator<char>(two), {}));
}

TEST(MetricsFile, KeepsTheRestWhenFramesAreSet) {
  const std::string path = scratchPath("frames.json");
  writeMetrics(path, makeResult());
  auto expected = readJson(path);
  setFrames(path, 1020);
  expected["frames"] = 1020;
  EXPECT_EQ(readJson(path), expected);
}

TEST(MetricsFile, RefusesToSetFramesInWhatIsNoObject) {
  EXPECT_THROW(setFrames(scratchPath("missing.json"), 1), SessionException);
  std::ofstream(scratchPath("array.json")) << "[1, 2]";
  EXPECT_THROW(setFrames(scratchPath("array.json"), 1), SessionException);
  std::ofstream(scratchPath("broken.json")) << "{\"frames\": ";
  EXPECT_THROW(setFrames(scratchPath("broken.json"), 1), SessionException);
}

TEST(MetricsFile, RefusesAFolderThatIsNotThere) {
  EXPECT_THROW(writeMetrics(scratchPath("none") + "/metrics.json", makeResult()), SessionException);
  EXPECT_THROW(writeFaults(scratchPath("none") + "/faults.json", makeResult()), SessionException);
}

TEST(FaultsFile, GivesBothClocks) {
  writeFaults(scratchPath("faults.json"), makeResult());
  const auto event = readJson(scratchPath("faults.json")).at("faults").at(0);
  EXPECT_EQ(event.at("name"), "sudden_jump");
  EXPECT_EQ(event.at("model"), (nlohmann::json{{"first_tick", 8000}, {"last_tick", 8299}}));
  EXPECT_EQ(event.at("robot"), (nlohmann::json{{"first_cycle", 12001}, {"last_cycle", 12300}}));
}

TEST(ComputeMetrics, ReadsALogAsItWasFed) {
  const std::string path = scratchPath("session.rlog");
  SessionCounts counts;
  counts.master.received = 17;
  {
    session::LogWriter log(path, makeHeader());
    for (Tick t = 0; t < 1500; ++t) {
      if (t == 590 || t == 700) log.write(makeChange(makeTick(t, 0.0), 2, t == 590));
      log.write(makeTick(t, t >= 600 && t < 700 ? 0.007 : 0.001));
      log.write(makeForce(t, t >= 601 && t < 700 ? 1.25 : 0.0, t >= 600 && t < 700 ? 0.007 : 0.001));
    }
    PlanRecord plan;
    plan.result.status = PlanStatus::kSuccess;
    log.write(plan);
    log.write(makeExecution(100, 900));
    log.finish(counts);
  }
  const SessionMetrics result = computeMetrics(path);
  EXPECT_EQ(result.ticks, 1500u);
  ASSERT_EQ(result.faults.size(), 1u);
  EXPECT_EQ(result.faults[0].first_tick, 590);
  EXPECT_EQ(result.faults[0].errorToForce(), 1);
  EXPECT_EQ(result.plan.status, PlanStatus::kSuccess);
  ASSERT_EQ(result.executions.size(), 1U);
  EXPECT_EQ(result.executions[0].report.started, 100);
  EXPECT_EQ(result.counts.master.received, 17u);
  EXPECT_TRUE(result.complete);
  EXPECT_THROW(computeMetrics(scratchPath("missing.rlog")), SessionException);
}

/** packets.daemon_to_robot and counters_add_up of a session that added up, changed. */
nlohmann::json relayOf(const std::function<void(SessionCounts*)>& change) {
  SessionMetrics result = makeResult();
  result.complete = true;
  result.counts = SessionCounts{};
  result.counts.relay_sent = 88;
  result.counts.rings[static_cast<std::size_t>(RingId::kRelayPackets)] = {88, 88, 0};
  result.counts.robot_state.received = result.counts.robot_state.applied = 50;
  change(&result.counts);
  writeMetrics(scratchPath("relay.json"), result);
  const auto json = readJson(scratchPath("relay.json"));
  return {{"link", json.at("packets").at("daemon_to_robot")}, {"adds_up", json.at("counters_add_up")}};
}

TEST(MetricsFile, WhatARobotDoesNotReportIsUnknownAndNotNought) {
  const auto real = relayOf([](SessionCounts*) {});
  for (const char* key : {"received", "applied", "rejected"})
    EXPECT_TRUE(real.at("link").at(key).is_null()) << key;
  EXPECT_EQ(real.at("link").at("sent"), 88);
  EXPECT_TRUE(real.at("adds_up").is_null());
  const auto broken = relayOf([](SessionCounts* counts) { counts->robot_state.received = 51; });
  EXPECT_EQ(broken.at("adds_up"), false) << "the known counts do not add up";
  const auto emulated = relayOf([](SessionCounts* counts) { counts->relay.received = counts->relay.applied = 87; });
  EXPECT_EQ(emulated.at("link").at("received"), 87);
  EXPECT_EQ(emulated.at("adds_up"), true);
  const auto alone = relayOf([](SessionCounts* counts) { counts->robot_state = {}; });
  EXPECT_EQ(alone.at("link").at("received"), 0) << "there was no robot to ask";
  EXPECT_EQ(alone.at("adds_up"), true);
}

TEST(MetricsFile, HasNoErrorOfARobotThatHeldStill) {
  SessionMetrics result = makeResult();
  result.executions[0].report.on_robot = 0;
  writeMetrics(scratchPath("still.json"), result);
  const auto execution = readJson(scratchPath("still.json")).at("executions").at(0);
  EXPECT_TRUE(execution.at("robot_error_mm").is_null());
  EXPECT_DOUBLE_EQ(execution.at("model_error_mm").at("mean"), 0.5);
}

/** Only `arm`'s force and error are not 0. */
HapticRecord makeForceOf(Arm arm, Tick session_tick, double newton, double error) {
  HapticRecord record;
  record.haptic.tick = kOrigin + session_tick;
  record.haptic.active = 1;
  at(record.haptic.error, arm) = error;
  at(record.haptic.force_B, arm) = {0.0, newton, 0.0};
  return record;
}

TEST(FaultEvent, HasTheErrorAndTheForceOfEitherArm) {
  for (const Arm arm : kArms) {
    Accumulator metrics(makeHeader());
    metrics.feels = false;
    for (Tick t = 0; t < 2000; ++t) {
      TickRecord record = makeTick(t, 0.0, t >= 1000 && t < 1100 ? 2 : 0);
      const bool is_apart = t >= 1020 && t < 1100;
      at(record.model.arms, arm).p_BT[0] += is_apart ? 0.012 : 0.001;
      metrics.add(record);
      const double newton = t >= 1030 && t < 1100 ? 2.5 : t == 500 ? 0.75 : 0.0;
      metrics.add(makeForceOf(arm, t, newton, is_apart ? 0.012 : 0.001));
    }
    const SessionMetrics result = metrics.result();
    ASSERT_EQ(result.faults.size(), 1U);
    EXPECT_NEAR(result.faults[0].max_error, 0.012, 1e-15);
    EXPECT_NEAR(result.faults[0].max_force, 2.5, 1e-15);
    EXPECT_EQ(result.faults[0].onset_tick, 1020);
    EXPECT_EQ(result.faults[0].force_tick, 1030);
    EXPECT_NEAR(result.max_force, 2.5, 1e-15);
    EXPECT_NEAR(result.error_max_force, 0.75, 1e-15);
    EXPECT_NEAR(result.error.mean(), 0.001, 1e-15);
  }
}

FaultChangeRecord makeChangeOf(FaultHost host, const TickRecord& record, std::uint32_t id, bool acts) {
  FaultChangeRecord change = makeChange(record, id, acts);
  change.change.host = host;
  change.change.cycle = 5;  // the host's own clock
  return change;
}

TEST(Injections, OfTheDaemonAreOnTheRobotsClockAndOutliveItsLink) {
  MetricsAccumulator metrics(makeHeader());
  TickRecord record = makeTick(3, 0.0);
  metrics.add(makeChangeOf(FaultHost::kRobot, record, 1, true));
  metrics.add(makeChangeOf(FaultHost::kRelay, record, 2, true));
  metrics.add(record);
  record = makeTick(10, 0.0);
  record.robot.connected = 0;
  metrics.add(record);
  std::vector<Injection> all = metrics.result().injections;
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].inject_cycle, 5U) << "the robot reports its own faults";
  EXPECT_EQ(all[0].clear_tick, 10);
  EXPECT_TRUE(all[0].is_assumed);
  EXPECT_EQ(all[1].inject_cycle, 70003U) << "the daemon's is stamped with the robot's cycle";
  EXPECT_EQ(all[1].clear_tick, -1) << "the daemon goes on";
  EXPECT_FALSE(all[1].is_assumed);
  record = makeTick(20, 0.0);
  metrics.add(makeChangeOf(FaultHost::kRelay, record, 2, false));
  metrics.add(record);
  all = metrics.result().injections;
  EXPECT_EQ(all[1].clear_tick, 20);
  EXPECT_EQ(all[1].clear_cycle, 70020U);
  EXPECT_EQ(all[0].clear_tick, 10) << "of another host, with another id";
}

/** Of two faults at once the robot's names the event, whichever began first. */
TEST(Injections, TheRobotsFaultNamesTheEventOfTwoAtOnce) {
  for (const bool robot_first : {true, false}) {
    MetricsAccumulator metrics(makeHeader());
    const TickRecord record = makeTick(3, 0.0);
    if (robot_first) metrics.add(makeChangeOf(FaultHost::kRobot, record, 1, true));
    metrics.add(makeChangeOf(FaultHost::kRelay, record, 2, true));
    if (!robot_first) metrics.add(makeChangeOf(FaultHost::kRobot, record, 1, true));
    metrics.add(record);
    EXPECT_EQ(metrics.result().faults.at(0).name, "other");
  }
}

ExerciseAttempt makeAttempt() {
  ExerciseAttempt attempt;
  attempt.state.attempt = 2;
  attempt.state.status = ExerciseStatus::kFailed;
  attempt.state.failure = ExerciseFailure::kTimeLimit;
  attempt.state.step = 4;
  attempt.began = 101;
  attempt.ended = 7103;
  attempt.ticks = 6500;
  for (std::size_t i = 0; i < kMistakeCount; ++i)
    attempt.state.mistakes[i] = static_cast<std::uint32_t>(i) + 11;
  for (std::size_t i = 0; i < kExerciseEventKindCount; ++i)
    attempt.events[i] = i + 31;
  return attempt;
}

TEST(MetricsFile, SaysHowAnAttemptAtTheExerciseWent) {
  SessionMetrics result = makeResult();
  result.exercise = "peg_transfer";
  result.attempts = {makeAttempt()};
  result.attempts_beyond = 3;
  writeMetrics(scratchPath("attempt.json"), result);
  const auto json = readJson(scratchPath("attempt.json")).at("exercise");
  EXPECT_EQ(json.at("name"), "peg_transfer");
  EXPECT_TRUE(json.at("drill").is_null());
  EXPECT_EQ(json.at("attempts_beyond"), 3);
  const auto& attempt = json.at("attempts").at(0);
  EXPECT_EQ(attempt.at("number"), 2);
  EXPECT_EQ(attempt.at("status"), "failed");
  EXPECT_EQ(attempt.at("failure"), "time_limit");
  EXPECT_EQ(attempt.at("began_tick"), 101);
  EXPECT_EQ(attempt.at("ended_tick"), 7103);
  EXPECT_DOUBLE_EQ(attempt.at("time_s"), 6.5);
  EXPECT_EQ(attempt.at("steps_done"), 3);
  for (std::size_t i = 0; i < kMistakeCount; ++i)
    EXPECT_EQ(attempt.at("mistakes").at(kMistakeNames[i]), i + 11);
  for (std::size_t i = 0; i < kExerciseEventKindCount; ++i)
    EXPECT_EQ(attempt.at("events").at(kExerciseEventNames[i]), i + 31);
}

TEST(MetricsFile, SaysPlansAndExecutionsInTheUnitsOfTheirNames) {
  SessionMetrics result = makeResult();
  result.plan.status = PlanStatus::kSuccess;
  result.plan.cost = 6.5;
  result.plan.planning_time = 1.25;
  result.plan.waypoint_count = 14;
  result.plan.samples = 500;
  ExecutionReport& report = result.executions[0].report;
  report.planned_clearance = 0.0041;
  report.model_clearance = 0.0042;
  report.robot_clearance = 0.0043;
  report.contact_points = 17;
  writeMetrics(scratchPath("plans.json"), result);
  const auto json = readJson(scratchPath("plans.json"));
  const auto& plan = json.at("plan");
  EXPECT_EQ(plan.at("success"), true);
  EXPECT_EQ(plan.at("cost"), 6.5);
  EXPECT_EQ(plan.at("planning_time_s"), 1.25);
  EXPECT_EQ(plan.at("waypoints"), 14);
  EXPECT_EQ(plan.at("samples"), 500);
  const auto& execution = json.at("executions").at(0);
  EXPECT_EQ(execution.at("path_time_s"), 2.5);
  EXPECT_DOUBLE_EQ(execution.at("planned_clearance_mm"), 4.1);
  EXPECT_DOUBLE_EQ(execution.at("model_clearance_mm"), 4.2);
  EXPECT_DOUBLE_EQ(execution.at("robot_clearance_mm"), 4.3);
  EXPECT_EQ(execution.at("contact_points"), 17);
  for (const auto& [who, error] : {std::pair{"model", report.model}, {"robot", report.robot}}) {
    const auto& told = execution.at(std::string(who) + "_error_mm");
    EXPECT_DOUBLE_EQ(told.at("mean"), 1e3 * error.mean) << who;
    EXPECT_DOUBLE_EQ(told.at("max"), 1e3 * error.largest) << who;
    EXPECT_DOUBLE_EQ(told.at("at_end"), 1e3 * error.at_end) << who;
  }
}

TEST(MetricsFile, SaysEachLoopsTimesInMicroseconds) {
  SessionMetrics result = makeResult();
  for (std::size_t i = 0; i < kLoopCount; ++i) {
    LoopTiming& loop = result.counts.loops[i];
    loop.ticks = 1000;
    loop.on_time = 900 + 10 * i;
    loop.late_runs = 3 + i;
    loop.longest_late_run = 5 + i;
    loop.last_run_late_ns = 7500 + static_cast<std::int64_t>(i);
    loop.max_late_ns = 8500 + static_cast<std::int64_t>(i);
    loop.max_run_ns = 9500 + static_cast<std::int64_t>(i);
    loop.minor_faults = 11 + i;
    loop.major_faults = 13 + i;
    for (int n = 0; n < 1000; ++n) {
      loop.wake_up.add(50'000);
      loop.run.add(200'000);
    }
  }
  writeMetrics(scratchPath("loops.json"), result);
  const auto json = readJson(scratchPath("loops.json"));
  for (std::size_t i = 0; i < kLoopCount; ++i) {
    const auto& loop = json.at("timing").at(kLoopNames[i]);
    const double n = static_cast<double>(i);
    EXPECT_DOUBLE_EQ(json.at("on_time_ratio").at(kLoopNames[i]), 0.9 + 0.01 * n);
    EXPECT_EQ(loop.at("late_runs"), 3 + i);
    EXPECT_EQ(loop.at("longest_late_run"), 5 + i);
    EXPECT_DOUBLE_EQ(loop.at("last_run_late_us"), 7.5 + 0.001 * n);
    EXPECT_DOUBLE_EQ(loop.at("max_late_us"), 8.5 + 0.001 * n);
    EXPECT_DOUBLE_EQ(loop.at("max_run_us"), 9.5 + 0.001 * n);
    EXPECT_EQ(loop.at("minor_faults"), 11 + i);
    EXPECT_EQ(loop.at("major_faults"), 13 + i);
    for (const char* share : {"p50", "p99", "p999"}) {  // an octave has eight buckets
      EXPECT_NEAR(loop.at("wake_up_us").at(share).get<double>(), 50.0, 50.0 / 8) << share;
      EXPECT_NEAR(loop.at("run_us").at(share).get<double>(), 200.0, 200.0 / 8) << share;
    }
  }
}

TEST(MetricsFile, CountsEachLinkAndQueueAsItsOwn) {
  SessionMetrics result = makeResult();
  SessionCounts& counts = result.counts;
  counts.relay_failed = 21;
  counts.relay_released = 22;
  counts.force_failed = 23;
  counts.force_silent = 24;
  counts.master_faults = {31, 32, 33};
  counts.relay_faults = {41, 42, 43};
  counts.relay_network = {51, 52, 53};
  for (std::size_t i = 0; i < kRingCount; ++i)
    counts.rings[i] = {1000 + i, 2000 + i, 3000 + i};
  counts.ik_clamped = 61;
  counts.records_dropped = 62;
  counts.contacts_dropped = 63;
  writeMetrics(scratchPath("links.json"), result);
  const auto json = readJson(scratchPath("links.json"));
  const auto& packets = json.at("packets");
  const auto& robot = packets.at("daemon_to_robot");
  const auto& console = packets.at("daemon_to_console");
  EXPECT_EQ(robot.at("failed"), 21);
  EXPECT_EQ(robot.at("released"), 22);
  EXPECT_EQ(robot.at("dropped"), ring(counts, RingId::kRelayPackets).dropped);
  EXPECT_EQ(console.at("failed"), 23);
  EXPECT_EQ(console.at("silent"), 24);
  EXPECT_EQ(console.at("dropped"), ring(counts, RingId::kForcePackets).dropped);
  EXPECT_EQ(packets.at("master_to_daemon").at("faults"), (nlohmann::json{{"lost", 31}, {"added", 32}, {"held", 33}}));
  EXPECT_EQ(robot.at("faults"), (nlohmann::json{{"lost", 41}, {"added", 42}, {"held", 43}}));
  EXPECT_EQ(robot.at("network"), (nlohmann::json{{"lost", 51}, {"added", 52}, {"held", 53}}));
  for (std::size_t i = 0; i < kRingCount; ++i) {
    const RingCounts& own = counts.rings[i];
    EXPECT_EQ(json.at("queues").at(kRingNames[i]),
              (nlohmann::json{{"pushed", own.pushed}, {"taken", own.taken}, {"dropped", own.dropped}}));
  }
  EXPECT_EQ(json.at("ik_clamped_ticks"), 61);
  EXPECT_EQ(json.at("records_dropped"), 62);
  EXPECT_EQ(json.at("contacts_dropped"), 63);
}

Injection makeInjection(std::int8_t arm) {
  Injection injection;
  injection.name = "sudden_jump";
  injection.fault.host = FaultHost::kRelay;
  injection.fault.row = 3;
  injection.fault.arm = arm;
  injection.fault.channel = arm < 0 ? -1 : 2;
  injection.fault.value = 1.5;
  injection.inject_tick = 71;
  injection.clear_tick = arm < 0 ? -1 : 82;
  injection.inject_cycle = 93;
  injection.clear_cycle = arm < 0 ? 0 : 104;
  injection.observe_tick = arm < 0 ? -1 : 75;
  injection.is_assumed = arm == 1;
  return injection;
}

TEST(FaultsFile, SaysArmChannelAndBothClocksOfEachInjection) {
  SessionMetrics result = makeResult();
  result.injections = {makeInjection(-1), makeInjection(0), makeInjection(1)};
  result.injections_beyond = 5;
  result.counts.fault_changes_lost = 6;
  writeFaults(scratchPath("injections.json"), result);
  const auto json = readJson(scratchPath("injections.json"));
  EXPECT_EQ(json.at("injections_beyond"), 5);
  EXPECT_EQ(json.at("changes_lost"), 6);
  const char* arms[] = {"both", "gold", "green"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& told = json.at("injections").at(i);
    const bool has_end = i > 0;
    EXPECT_EQ(told.at("arm"), arms[i]);
    EXPECT_EQ(told.at("channel"), has_end ? nlohmann::json(2) : nlohmann::json("all"));
    EXPECT_EQ(told.at("host"), kFaultHostNames[static_cast<std::size_t>(FaultHost::kRelay)]);
    EXPECT_EQ(told.at("row"), 3);
    EXPECT_EQ(told.at("value"), 1.5);
    EXPECT_EQ(told.at("inject"), (nlohmann::json{{"tick", 71}, {"cycle", 93}}));
    EXPECT_EQ(told.at("observe").at("tick"), has_end ? nlohmann::json(75) : nlohmann::json());
    EXPECT_EQ(told.at("clear").at("tick"), has_end ? nlohmann::json(82) : nlohmann::json());
    EXPECT_EQ(told.at("clear").at("cycle"), has_end ? nlohmann::json(104) : nlohmann::json());
    EXPECT_EQ(told.at("clear").at("assumed"), i == 2);
  }
}

TEST(Injections, AtTheUsbBoundaryOutliveTheRobotsLink) {
  for (const bool is_merged : {false, true}) {
    MetricsAccumulator metrics(makeHeader());
    TickRecord record = makeTick(3, 0.0);
    const FaultChangeRecord change = makeChange(record, 1, true);
    is_merged ? metrics.addMerged(change) : metrics.add(change);
    metrics.add(record);
    record = makeTick(10, 0.0);
    record.robot.connected = 0;
    metrics.add(record);
    metrics.add(makeTick(11, 0.0));
    const SessionMetrics result = metrics.result();
    EXPECT_EQ(result.injections.at(0).clear_tick, is_merged ? -1 : 10);
    EXPECT_EQ(result.injections.at(0).is_assumed, !is_merged);
  }
}

TEST(Injections, WithoutAnEffectHaveNotThatOfALaterOne) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 99, 0.001, 1);
  feed(&metrics, 100, 1999, 0.001);
  feed(&metrics, 2000, 2099, 0.005, 2);
  EXPECT_EQ(metrics.result().injections.at(0).observe_tick, -1);
  EXPECT_EQ(metrics.result().injections.at(1).observe_tick, 2000);
}

TEST(Injections, AreNotObservedBeforeTheyBegan) {
  Accumulator metrics(makeHeader());
  feed(&metrics, 0, 49, 0.001, 2);
  feed(&metrics, 50, 199, 0.005, 2);
  metrics.add(makeChange(makeTick(200, 0.005), 2, true, /*row=*/1));
  feed(&metrics, 200, 299, 0.005, 2);
  EXPECT_EQ(metrics.result().injections.at(0).observe_tick, 50);
  EXPECT_EQ(metrics.result().injections.at(1).observe_tick, -1);
}

}  // namespace
}  // namespace raven2_trainer::training
