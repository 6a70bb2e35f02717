#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/training/band.h"
#include "raven2_trainer/training/hazard_response.h"
#include "raven2_trainer/training/metric_names.h"
#include "raven2_trainer/training/motion_metrics.h"
#include "raven2_trainer/training/transit.h"

namespace raven2_trainer::training {

/** One number of an attempt. */
struct Metric {
  std::string name, unit;
  MetricGroup group{};
  Better better{};
  std::optional<double> value;  ///< in `unit`; nothing: not measured
};

/** Result of the exercise, as its judge reported it. */
struct AttemptOutcome {
  std::int64_t number{};  ///< of the attempt in its session, from 1
  ExerciseStatus status{ExerciseStatus::kNone};
  ExerciseFailure failure{ExerciseFailure::kNone};
  std::uint32_t steps{};  ///< done
  std::array<std::uint32_t, kMistakeCount> mistakes{};
  Tick first{-1}, last{-1};  ///< [1 ms] session ticks that count; -1: it failed before its timer started
  bool is_drill{};           ///< a hazard was to come in it
};

/** A hazard, and the response to it. */
struct HazardScore {
  std::string scenario;
  Tick injection{-1};  ///< [1 ms] session tick
  HazardResponse response;
};

/** All that can be scored, in a fixed order; doc/scores.md. Mistakes only where there is an exercise. */
std::vector<Metric> listMetrics(const MotionMetrics& motion, const AttemptOutcome& outcome, const Economy& economy);

/** Standard for attempts. */
struct Standard {
  const Band* band{};      ///< of the exercise; nullptr: nothing is judged. It must outlive the results
  double deviations{1.0};  ///< [-] spreads by which a metric may be worse than the band's mean
  /** Of the exercise: no other metric is judged, and none may violate its limit. Nothing: all of the band are judged.
   */
  std::optional<std::vector<ScoredMetric>> scored;
};

struct MetricScore {
  Metric metric;
  const BandMetric* band{};     ///< nullptr: not in the band
  std::optional<double> bound;  ///< in the metric's unit: the exercise's own limit
  bool is_scored{};             ///< the exercise asks for it, or the band has it where no exercise says
  bool is_judged{};             ///< scored, with a value and a band; the band or `bound` has it
  BandJudgement judgement{};    ///< by the band or by the bound, whichever is stricter
};

/** One attempt against the band of its exercise. */
struct AttemptScore {
  AttemptOutcome outcome;
  MotionMetrics motion;
  Economy economy;
  std::vector<HazardScore> hazards;
  std::vector<MetricScore> metrics;
  std::vector<std::string> not_judged;  ///< what is scored and was not measured, or is not in the band
  std::optional<bool> passed;           ///< nothing without band or exercise, or if only the drill's hazard was missing
  std::optional<double> composite;      ///< [-] share of the judged metrics that passed; decides nothing
  std::vector<std::string> improve;     ///< at most three: what to work on, most urgent first
};

constexpr const char* kHazardMetric = "hazard_response";  ///< in AttemptScore::improve, and in index.json

/** [s] From the cue to the answer, of the first hazard that was answered rightly, late or not; nothing: none was. */
std::optional<double> firstAnswer(const std::vector<HazardScore>& hazards);

/**
 * An attempt passes if the exercise was done and every measured scored metric is within its limit (no metric
 * compensates another). At least one must have been measured. Every hazard except Verdict::kNotJudged must have
 * been answered rightly and in time. One that would pass in a drill without such a hazard has neither passed nor
 * failed.
 */
AttemptScore scoreAttempt(const AttemptOutcome& outcome,
                          const MotionMetrics& motion,
                          const Economy& economy,
                          const std::vector<HazardScore>& hazards,
                          const Standard& standard);

}  // namespace raven2_trainer::training
