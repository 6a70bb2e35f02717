#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "raven2_trainer/raven/drives.h"
#include "raven2_trainer/studies/detector_study.h"
#include "support/effort.h"
#include "support/rig.h"

// Runs a seeded part of the evaluation that evaluate_detector runs in full (doc/detector.md), and checks the parts of
// that evaluation.

namespace raven2_trainer::lockstep {
namespace {

using Scenario = studies::StudyFault::Scenario;

std::vector<studies::StudyOutcome> evaluate(const studies::EvaluateOptions& options) {
  testing::useOde();
  std::vector<studies::StudyOutcome> outcomes;
  studies::evaluateDetector(
      testing::packagedConfig(), options, [&](const studies::StudyOutcome& o) { outcomes.push_back(o); },
      [](double) {});
  return outcomes;
}

/** One stuck value, -15000 counts, for 1 to 19 ms. */
studies::EvaluateOptions oneTorque() {
  studies::EvaluateOptions options;
  options.input_starts = options.add_starts = 0;
  options.torque_starts = 1;
  return options;
}

/** The outcomes of oneTorque(); computed once. */
const std::vector<studies::StudyOutcome>& outcomesOfOneTorque() {
  static const std::vector<studies::StudyOutcome> outcomes = evaluate(oneTorque());
  return outcomes;
}

/** Required rates: DSN 2016, table IV. The full evaluation is compared with the rates themselves. For the few runs here
 * (57 to 160 for each scenario) a binomial test is used. A detector with exactly these rates exceeds the granted number
 * of wrong runs in at most 2.5 of 100 choices of seeds. */
struct Bound {
  Scenario scenario;
  double true_positive, false_positive;
};

/** Least number that a binomial of `runs` and `rate` exceeds with a probability of at most 0.025. */
int granted(double rate, int runs) {
  double probability = std::pow(1.0 - rate, runs), sum = probability;
  int count = 0;
  while (sum < 0.975 && count < runs) {
    probability *= rate / (1.0 - rate) * (runs - count) / (count + 1);
    sum += probability;
    ++count;
  }
  return count;
}

TEST(DetectorRates, GrantedIsTheBinomialTail) {
  // P(X > 1) = 1 - 0.9^10 - 10 0.1 0.9^9 = 0.264, P(X > 3) = 0.0128, P(X > 2) = 0.070 for n = 10, p = 0.1
  EXPECT_EQ(granted(0.1, 10), 3);
  // n = 59, p = 0.002: P(X > 0) = 0.111, P(X > 1) = 0.0062
  EXPECT_EQ(granted(0.002, 59), 1);
}

TEST(DetectorRates, AreThoseOfThePaperOnAPartOfTheGrids) {
  studies::EvaluateOptions options;
  options.input_starts = 2;
  options.torque_starts = static_cast<int>(testing::effort(3, 5));
  options.add_starts = 1;
  const std::vector<studies::StudyOutcome> outcomes = evaluate(options);
  ASSERT_EQ(outcomes.size(), 2U * 48 + static_cast<std::size_t>(options.torque_starts) * 19 + 64);
  for (const Bound& bound : {Bound{Scenario::kInputs, 0.898, 0.124}, Bound{Scenario::kTorque, 0.998, 0.118}}) {
    const studies::StudyRates r = studies::ratesOf(outcomes, bound.scenario, DetectorRule::kDeparture, 1.0);
    std::printf("scenario %d: %d of %d unsafe, %d of %d safe, %d stopped\n", static_cast<int>(bound.scenario),
                r.detected, r.unsafe, r.false_alarms, r.safe, r.stopped);
    ASSERT_GT(r.unsafe, 10);
    ASSERT_GT(r.safe, 4);
    EXPECT_LE(r.unsafe - r.detected, granted(1.0 - bound.true_positive, r.unsafe));
    EXPECT_LE(r.false_alarms, granted(bound.false_positive, r.safe));
  }
}

TEST(DetectorRates, NoAlarmWithoutAFault) {
  testing::useOde();
  const TrainerConfig config = testing::packagedConfig();
  double largest = 0.0;
  const auto seeds = static_cast<std::uint64_t>(testing::effort(2, 4));
  for (std::uint64_t seed = 300001; seed <= 300000 + seeds; ++seed) {
    const studies::DetectorTrial trial(studies::studyConfig(config, seed), 5000);
    detector::AnomalyDetector detector(config.detector, raven::drivesOf(config.arms, config.virtual_raven));
    for (const studies::TrialTick& tick : trial.past())
      largest = std::max(largest, detector.step(studies::observationOf(tick)).size);
  }
  // 5 s of both arms from each seed. An alarm is a size above 1; without a fault the size must stay below half of that.
  EXPECT_GT(largest, 0.0);
  EXPECT_LT(largest, 0.5);
}

/** The packaged thresholds are of 600 runs. Few and short ones have the same order of size. */
TEST(DetectorLearning, EachAxisOfEachArmGetsThresholdsOfItsOwnForEitherRule) {
  testing::useOde();
  const TrainerConfig config = testing::packagedConfig();
  const studies::Learned learned = studies::learnDetector(config, {8, 1, 3000, 8, 99.9}, [](double) {});
  EXPECT_EQ(learned.runs, 8);
  const std::string text = studies::detectorYaml(learned, "a test");
  std::size_t from = 0;
  for (const Arm arm : kArms) {
    from = text.find(std::string(name(arm)) + ":\n", from);
    for (std::size_t i = 0; i < detector::kAxes; ++i) {
      const DetectorAxis &axis = at(learned.detector.axes, arm)[i], &shipped = at(config.detector.axes, arm)[i];
      for (const auto member : {&DetectorThresholds::acceleration, &DetectorThresholds::motor_velocity,
                                &DetectorThresholds::joint_velocity}) {
        EXPECT_NEAR(std::log(axis.published.*member / (shipped.published.*member)), 0.0, std::log(4.0))
            << name(arm) << i;
        EXPECT_NEAR(std::log(axis.departure.*member / (shipped.departure.*member)), 0.0, std::log(4.0))
            << name(arm) << i;
      }
      const double ratio = axis.published.motor_velocity / axis.departure.motor_velocity;
      EXPECT_NEAR(std::log(ratio / (shipped.published.motor_velocity / shipped.departure.motor_velocity)), 0.0, 0.5)
          << "each rule has its own";
      EXPECT_NE(axis.departure.motor_velocity, at(learned.detector.axes, otherArm(arm))[i].departure.motor_velocity);
      std::array<char, 64> expected{};
      std::snprintf(expected.data(), expected.size(), "departure: {acceleration: %.5g,", axis.departure.acceleration);
      from = text.find("departure:", from + 1);
      ASSERT_NE(from, std::string::npos);
      EXPECT_EQ(text.substr(from, std::string(expected.data()).size()), expected.data());
    }
  }
}

TEST(DetectorRates, SameSeedSameOutcomes) {
  const std::vector<studies::StudyOutcome>&once = outcomesOfOneTorque(), again = evaluate(oneTorque());
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].departure, again[i].departure);
    EXPECT_EQ(once[i].rules[1].in_time, again[i].rules[1].in_time);
    EXPECT_EQ(once[i].rules[0].in_time, again[i].rules[0].in_time);
  }
}

TEST(DetectorRates, TruthIsAboutTheTipAlone) {
  // GIVEN one stuck value for 1 to 19 ms THEN the departure grows with the length, and a run is unsafe exactly if it
  // departs by more than 1 mm. All unsafe runs are decided at the end of the shortest unsafe length.
  const std::vector<studies::StudyOutcome>& outcomes = outcomesOfOneTorque();
  ASSERT_EQ(outcomes.size(), 19U);
  Tick shortest = 0;
  for (const studies::StudyOutcome& o : outcomes) {
    EXPECT_EQ(o.is_unsafe, o.departure > oneTorque().unsafe);
    if (o.is_unsafe && shortest == 0) shortest = o.fault.length;
    EXPECT_EQ(o.decided, o.is_unsafe ? shortest - 1 : -1);
    EXPECT_TRUE(!o.is_unsafe || o.harmed >= o.decided) << "harm comes before the run is decided";
  }
  EXPECT_FALSE(outcomes.front().is_unsafe);
  EXPECT_TRUE(outcomes.back().is_unsafe);
  for (std::size_t i = 1; i < outcomes.size(); ++i)
    EXPECT_GT(outcomes[i].departure, outcomes[i - 1].departure);
}

TEST(DetectorRates, StoppedRunsAreInNoRate) {
  std::vector<studies::StudyOutcome> outcomes(4);
  for (studies::StudyOutcome& o : outcomes)
    o.rules[1].in_time = 2.0;
  outcomes[0].is_unsafe = true;
  outcomes[1].stopped = 5;
  outcomes[3].rules[1].in_time = 0.5;
  const studies::StudyRates r = studies::ratesOf(outcomes, Scenario::kInputs, DetectorRule::kDeparture, 1.0);
  EXPECT_EQ(r.unsafe, 1);
  EXPECT_EQ(r.detected, 1);
  EXPECT_EQ(r.stopped, 1);
  EXPECT_EQ(r.alarms_before_stop, 1);
  EXPECT_EQ(r.safe, 2);
  EXPECT_EQ(r.false_alarms, 1);
  EXPECT_EQ(studies::ratesOf(outcomes, Scenario::kInputs, DetectorRule::kDeparture, 3.0).detected, 0);
}

}  // namespace
}  // namespace raven2_trainer::lockstep
