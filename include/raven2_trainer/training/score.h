#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/core/band.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/training/band.h"
#include "raven2_trainer/training/hazard_response.h"
#include "raven2_trainer/training/motion_metrics.h"
#include "raven2_trainer/training/transit.h"

namespace raven2_trainer::training {

/** As the industry groups them (field.md 5.4). */
enum class MetricGroup : std::uint8_t { kEfficiency, kSafety, kControl };
constexpr std::array<const char*, 3> kMetricGroupNames{"efficiency", "safety", "control"};

/** One number of an attempt. */
struct Metric {
  std::string name, unit;
  MetricGroup group{};
  Better better{};
  std::optional<double> value;  ///< in `unit`; nothing: not measured
};

/** How the exercise went, as its judge told it. */
struct AttemptOutcome {
  std::int64_t number{};  ///< of the attempt in its session, from 1
  ExerciseStatus status{ExerciseStatus::kNone};
  ExerciseFailure failure{ExerciseFailure::kNone};
  std::uint32_t steps{};  ///< done
  std::array<std::uint32_t, kMistakeCount> mistakes{};
  Tick first{-1}, last{-1};  ///< [1 ms] session ticks that count
  bool is_drill{};           ///< a hazard was to come in it
};

/** What a hazard was, and what was done about it. */
struct HazardScore {
  std::string scenario;
  Tick injection{-1};  ///< [1 ms] session tick
  HazardResponse response;
};

/** All that can be scored, in a fixed order; doc/scores.md. Mistakes only where there is an exercise. */
std::vector<Metric> listMetrics(const MotionMetrics& motion, const AttemptOutcome& outcome, const Economy& economy);

struct MetricScore {
  Metric metric;
  const BandMetric* band{};  ///< nullptr: told, not scored
  BandJudgement judgement{};
  bool is_judged{};  ///< there are a band and a value
};

/** One attempt against the band of its exercise. */
struct AttemptScore {
  AttemptOutcome outcome;
  MotionMetrics motion;
  Economy economy;
  std::vector<HazardScore> hazards;
  std::vector<MetricScore> metrics;
  std::vector<std::string> not_judged;  ///< of the band, what was not measured
  std::optional<bool> passed;           ///< nothing without a band
  std::optional<double> composite;      ///< [-] share of the judged metrics that passed; decides nothing
  std::vector<std::string> improve;     ///< at most three: what to work on, most urgent first
};

constexpr const char* kHazardMetric = "hazard_response";  ///< in AttemptScore::improve

/**
 * An attempt passes if the exercise was done, every metric of the band that was measured lies within it (none makes up
 * for another), at least one was, and every hazard was answered rightly and in time; in a drill one must have come.
 * @param[in] band of the exercise; nullptr: nothing is judged. It must outlive the result.
 * @param[in] deviations [-] that a metric may be worse than the mean.
 */
AttemptScore scoreAttempt(const AttemptOutcome& outcome,
                          const MotionMetrics& motion,
                          const Economy& economy,
                          const std::vector<HazardScore>& hazards,
                          const Band* band,
                          double deviations);

}  // namespace raven2_trainer::training
