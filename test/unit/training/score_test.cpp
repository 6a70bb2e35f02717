#include "raven2_trainer/training/score.h"

#include <algorithm>

#include "gtest/gtest.h"
#include "raven2_trainer/training/metric_names.h"

namespace raven2_trainer::training {
namespace {

const Metric& metricOf(const std::vector<Metric>& metrics, const std::string& name) {
  return *std::find_if(metrics.begin(), metrics.end(), [&](const Metric& m) { return m.name == name; });
}

Touches& touches(MotionMetrics* motion, Partner partner) {
  return motion->touches[static_cast<std::size_t>(partner)];
}

MotionMetrics makeMotion() {
  MotionMetrics motion;
  motion.duration = 50.0;
  motion.ticks = 50000;
  at(motion.hands, Arm::kGold).path = 0.3;
  at(motion.hands, Arm::kGreen).path = 0.1;
  at(motion.hands, Arm::kGold).sparc = -4.0;
  at(motion.hands, Arm::kGreen).sparc = -8.0;
  at(motion.hands, Arm::kGold).master_radius = 0.02;
  at(motion.hands, Arm::kGreen).master_radius = 0.05;
  motion.clutches = 3;
  motion.contact_force.peak = 2.5;
  return motion;
}

AttemptOutcome makeOutcome(ExerciseStatus status = ExerciseStatus::kDone) {
  AttemptOutcome outcome;
  outcome.status = status;
  return outcome;
}

/** A band that makeMotion() passes. */
Band makeBand() {
  Band band;
  band.metrics = {{"time", 45.0, 6.0, Better::kLower, 0.0},
                  {"path", 380.0, 50.0, Better::kLower, 0.0},
                  {"sparc", -4.8, 0.5, Better::kHigher, 0.0},
                  {"drops", 0.0, 0.0, Better::kLower, 0.0}};
  return band;
}

AttemptScore score(const Band& band,
                   const MotionMetrics& motion = makeMotion(),
                   const AttemptOutcome& outcome = makeOutcome(),
                   const std::vector<HazardScore>& hazards = {}) {
  return scoreAttempt(outcome, motion, {}, hazards, {&band, 1.0, {}});
}

TEST(Metrics, ComeInTheirUnits) {
  const std::vector<Metric> metrics = listMetrics(makeMotion(), makeOutcome(), {});
  EXPECT_NEAR(*metricOf(metrics, "path").value, 400.0, 1e-9);
  EXPECT_EQ(metricOf(metrics, "path").unit, "mm");
  EXPECT_NEAR(*metricOf(metrics, "sparc").value, 0.75 * -4.0 + 0.25 * -8.0, 1e-12);  // by the hands' paths
  EXPECT_NEAR(*metricOf(metrics, "master_radius").value, 50.0, 1e-9);                // the larger
  EXPECT_EQ(metricOf(metrics, "master_radius").group, MetricGroup::kControl);
  EXPECT_EQ(metricOf(metrics, "peak_force").group, MetricGroup::kSafety);
  EXPECT_EQ(metricOf(metrics, "sparc").better, Better::kHigher);
}

TEST(Metrics, ThatWereNotMeasuredHaveNoValue) {
  const std::vector<Metric> metrics = listMetrics(makeMotion(), makeOutcome(ExerciseStatus::kNone), {});
  for (const char* name : {"ldlj", "tremor", "out_of_view", "bimanual", "tracking", "drops", "break_offs"})
    EXPECT_FALSE(metricOf(metrics, name).value) << name;
}

TEST(Metrics, TakeTheJudgesCountWhereThereIsAnExercise) {
  MotionMetrics motion = makeMotion();
  touches(&motion, Partner::kWire).count = 4;
  touches(&motion, Partner::kObjectWire).count = 5;
  touches(&motion, Partner::kTower).count = 2;
  touches(&motion, Partner::kOtherArm).count = 1;
  touches(&motion, Partner::kObject).count = 70;
  AttemptOutcome outcome = makeOutcome(ExerciseStatus::kNone);
  outcome.mistakes[static_cast<std::size_t>(Mistake::kWireTouch)] = 1;
  EXPECT_EQ(*metricOf(listMetrics(motion, outcome, {}), "wire_touches").value, 9.0);
  EXPECT_EQ(*metricOf(listMetrics(motion, outcome, {}), "collisions").value, 3.0);
  outcome.status = ExerciseStatus::kFailed;
  EXPECT_EQ(*metricOf(listMetrics(motion, outcome, {}), "wire_touches").value, 1.0);
  EXPECT_EQ(*metricOf(listMetrics(motion, outcome, {}), "collisions").value, 0.0);
}

TEST(Score, PassesWithinTheBand) {
  const Band band = makeBand();
  const AttemptScore result = score(band);
  EXPECT_EQ(result.passed, true);
  EXPECT_EQ(result.composite, 1.0);
  EXPECT_TRUE(result.not_judged.empty());
}

TEST(Score, OneBadMetricFailsAll) {
  const Band band = makeBand();
  MotionMetrics slow = makeMotion();
  slow.duration = 52.0;
  EXPECT_EQ(score(band, slow).passed, false);
  EXPECT_EQ(score(band, slow).composite, 0.75);
  AttemptOutcome dropped = makeOutcome();
  dropped.mistakes[static_cast<std::size_t>(Mistake::kDrop)] = 1;
  EXPECT_EQ(score(band, makeMotion(), dropped).passed, false);
}

TEST(Score, AnAttemptThatWasNotDoneDoesNotPass) {
  const Band band = makeBand();
  for (const ExerciseStatus status : {ExerciseStatus::kFailed, ExerciseStatus::kRunning})
    EXPECT_EQ(score(band, makeMotion(), makeOutcome(status)).passed, false);
}

TEST(Score, WithoutABandNothingIsJudged) {
  const AttemptScore result = scoreAttempt(makeOutcome(), makeMotion(), {}, {}, {});
  EXPECT_FALSE(result.passed);
  EXPECT_FALSE(result.composite);
  EXPECT_TRUE(result.improve.empty());
}

TEST(Score, WithoutAnExerciseABandJudgesTheMetricsAlone) {
  const Band band = makeBand();
  const AttemptScore result = score(band, makeMotion(), makeOutcome(ExerciseStatus::kNone));
  EXPECT_EQ(result.passed, std::nullopt);
  EXPECT_EQ(result.composite, 1.0);
}

TEST(Score, WhatWasNotMeasuredIsNotJudgedAndSaid) {
  Band band = makeBand();
  band.metrics.push_back({"ldlj", -9.0, 1.0, Better::kHigher, 0.0});
  band.metrics.push_back({"unheard_of", 0.0, 1.0, Better::kLower, 0.0});
  const AttemptScore result = score(band);
  EXPECT_EQ(result.passed, true);
  EXPECT_EQ(result.not_judged, (std::vector<std::string>{"ldlj", "unheard_of"}));
}

ScoredMetric makeScored(const std::string& name) {
  ScoredMetric metric;
  metric.name = name;
  return metric;
}

ScoredMetric makeLimited(const std::string& name, double limit) {
  ScoredMetric metric = makeScored(name);
  metric.has_limit = 1;
  metric.limit = limit;
  return metric;
}

AttemptScore scoreBy(const std::vector<ScoredMetric>& scored, const MotionMetrics& motion = makeMotion()) {
  static const Band band = makeBand();
  return scoreAttempt(makeOutcome(), motion, {}, {}, {&band, 1.0, scored});
}

const MetricScore& scoreOf(const AttemptScore& score, const std::string& name) {
  return *std::find_if(score.metrics.begin(), score.metrics.end(),
                       [&](const MetricScore& m) { return m.metric.name == name; });
}

TEST(Score, JudgesWhatTheExerciseAsksForAlone) {
  MotionMetrics slow = makeMotion();
  slow.duration = 60.0;  // beyond the band's 51
  const AttemptScore result = scoreBy({makeScored("path"), makeScored("sparc")}, slow);
  EXPECT_EQ(result.passed, true);
  EXPECT_FALSE(scoreOf(result, "time").is_scored);
  EXPECT_FALSE(scoreOf(result, "time").is_judged);
  EXPECT_EQ(scoreOf(result, "time").band->mean, 45.0) << "still reported";
  EXPECT_TRUE(scoreOf(result, "path").is_scored);
  EXPECT_EQ(scoreBy({makeScored("time"), makeScored("path")}, slow).passed, false);
}

TEST(Score, SaysWhatTheExerciseAsksForAndNobodyCanJudge) {
  const AttemptScore result = scoreBy({makeScored("time"), makeScored("ldlj"), makeScored("clutches")});
  EXPECT_EQ(result.passed, true);
  EXPECT_EQ(result.not_judged, (std::vector<std::string>{"ldlj", "clutches"}));  // not measured; not in the band
  EXPECT_EQ(scoreBy({}).passed, false) << "nothing was judged";
}

TEST(Score, HoldsMetricsAgainstTheExercisesLimits) {
  // 50 s, 400 mm, 2.5 N; the band's limits are 51 s, 430 mm and none for the force
  EXPECT_EQ(scoreBy({makeLimited("time", 50.5), makeLimited("path", 401.0)}).passed, true);
  EXPECT_EQ(scoreBy({makeLimited("time", 49.0)}).passed, false);
  EXPECT_EQ(scoreOf(scoreBy({makeLimited("time", 49.0)}), "time").judgement.limit, 49.0);
  EXPECT_EQ(scoreOf(scoreBy({makeLimited("time", 70.0)}), "time").judgement.limit, 51.0) << "the stricter one";
  EXPECT_EQ(scoreBy({makeLimited("peak_force", 2.6)}).passed, true);
  EXPECT_EQ(scoreBy({makeLimited("peak_force", 2.4)}).passed, false);
  EXPECT_EQ(scoreBy({makeLimited("sparc", -4.9)}).passed, false);  // higher is better; it is -5
  EXPECT_EQ(scoreBy({makeLimited("sparc", -5.2)}).passed, true);
}

TEST(Score, DoesNotTakeTheForceThatIsComparedWithForATime) {
  MotionMetrics motion = makeMotion();
  motion.contact_force.above = 2000;  // [ms]
  const AttemptScore result = scoreBy({makeScored("time"), makeLimited("force_above", 1.0)}, motion);
  EXPECT_FALSE(scoreOf(result, "force_above").bound);
  EXPECT_FALSE(scoreOf(result, "force_above").is_judged);
  EXPECT_EQ(result.passed, true);
}

TEST(Score, LimitsAloneAreNoBand) {
  const AttemptScore result =
      scoreAttempt(makeOutcome(), makeMotion(), {}, {}, {nullptr, 1.0, {{makeLimited("time", 1.0)}}});
  EXPECT_FALSE(result.passed);
  EXPECT_FALSE(scoreOf(result, "time").is_judged);
  EXPECT_EQ(scoreOf(result, "time").bound, 1.0);
}

TEST(Score, OfNothingMeasuredIsNoPass) {
  Band band;
  band.metrics = {{"ldlj", -9.0, 1.0, Better::kHigher, 0.0}};
  EXPECT_EQ(score(band).passed, false);
  EXPECT_FALSE(score(band).composite);
}

TEST(Score, NamesTheThreeWorstFirst) {
  const Band band = makeBand();
  MotionMetrics motion = makeMotion();
  motion.duration = 45.0 + 6.0 + 12.0;       // two spreads beyond the limit
  at(motion.hands, Arm::kGold).path = 0.55;  // 650: 220 mm, 4.4 spreads beyond; sparc then -4.6 passes
  const AttemptScore result = score(band, motion);
  EXPECT_EQ(result.improve, (std::vector<std::string>{"path", "time"}))
      << "zero drops are exactly at the limit, and perfect";
}

TEST(Score, NamesThreeAtMost) {
  const Band band = makeBand();
  MotionMetrics bad = makeMotion();
  bad.duration = 500.0;
  for (HandMotion& hand : bad.hands) {
    hand.path *= 5.0;
    hand.sparc = -20.0;
  }
  AttemptOutcome dropped = makeOutcome();
  dropped.mistakes[static_cast<std::size_t>(Mistake::kDrop)] = 1;
  EXPECT_EQ(score(band, bad, dropped).improve.size(), 3U);
  HazardScore wrong;
  wrong.response.verdict = Verdict::kWrong;
  const std::vector<std::string> with_hazard = score(band, bad, dropped, {wrong}).improve;
  EXPECT_EQ(with_hazard.size(), 3U);
  EXPECT_EQ(with_hazard.front(), kHazardMetric);
}

TEST(Score, APassIsAMatterForAdviceOnlyWhereItNearlyFailed) {
  const Band band = makeBand();
  MotionMetrics motion = makeMotion();
  motion.duration = 45.0 + 6.0 - 0.24 * 6.0;  // a spread of 6 s
  EXPECT_EQ(score(band, motion).improve, (std::vector<std::string>{"time"}));
  motion.duration = 45.0 + 6.0 - 0.26 * 6.0;
  EXPECT_TRUE(score(band, motion).passed.value());
  EXPECT_TRUE(score(band, motion).improve.empty());
}

HazardScore makeHazard(Verdict verdict) {
  HazardScore hazard;
  hazard.response.verdict = verdict;
  return hazard;
}

TEST(Score, AHazardThatIsNotAnsweredRightlyFailsAndComesFirst) {
  const Band band = makeBand();
  EXPECT_EQ(score(band, makeMotion(), makeOutcome(), {makeHazard(Verdict::kRight)}).passed, true);
  for (const Verdict verdict : {Verdict::kNone, Verdict::kLate, Verdict::kWrong}) {
    const AttemptScore result =
        score(band, makeMotion(), makeOutcome(), {makeHazard(Verdict::kRight), makeHazard(verdict)});
    EXPECT_EQ(result.passed, false);
    EXPECT_EQ(result.improve.front(), kHazardMetric);
  }
}

TEST(Score, TheFirstRightAnswerIsTimedFromItsCue) {
  std::vector<HazardScore> hazards;
  for (const Verdict verdict : {Verdict::kNotJudged, Verdict::kWrong, Verdict::kLate, Verdict::kRight}) {
    hazards.push_back(makeHazard(verdict));
    hazards.back().response.cue_after = 100;
    hazards.back().response.deciding = {Response::kPedalUp, 500 + 1000 * static_cast<Tick>(verdict)};
  }
  EXPECT_EQ(firstAnswer({}), std::nullopt);
  EXPECT_EQ(firstAnswer({hazards[0], hazards[1]}), std::nullopt);
  EXPECT_NEAR(firstAnswer(hazards).value(), 2.4, 1e-12);
  EXPECT_NEAR(firstAnswer({hazards[3]}).value(), 1.4, 1e-12);
}

TEST(Score, AHazardThatNobodyCouldNoticeNeitherPassesNorFails) {
  const Band band = makeBand();
  AttemptOutcome outcome = makeOutcome();
  const HazardScore nothing = makeHazard(Verdict::kNotJudged), right = makeHazard(Verdict::kRight);
  EXPECT_EQ(score(band, makeMotion(), outcome, {nothing}).passed, true) << "no drill asked for a response";
  EXPECT_EQ(score(band, makeMotion(), outcome, {nothing, makeHazard(Verdict::kNone)}).passed, false);
  outcome.is_drill = true;
  for (const std::vector<HazardScore>& hazards : {std::vector<HazardScore>{}, {nothing}}) {
    EXPECT_EQ(score(band, makeMotion(), outcome, hazards).passed, std::nullopt);
    for (const std::string& advice : score(band, makeMotion(), outcome, hazards).improve)
      EXPECT_NE(advice, kHazardMetric);
    MotionMetrics slow = makeMotion();
    slow.duration = 500.0;
    EXPECT_EQ(score(band, slow, outcome, hazards).passed, false) << "a failure without the hazard remains";
  }
  EXPECT_EQ(score(band, makeMotion(), outcome, {nothing, right}).passed, true);
}

}  // namespace
}  // namespace raven2_trainer::training
