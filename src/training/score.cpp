#include "raven2_trainer/training/score.h"

#include <algorithm>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/training/metric_names.h"
#include "training/units.h"

namespace raven2_trainer::training {

namespace {

constexpr std::size_t kMostAdvice = 3;
constexpr double kNear = 0.25;  // [-] spreads, or shares of a bound, by which a pass is no near one

using Value = std::optional<double>;

Value scaled(const Value& value, double factor) {
  return value ? Value(*value * factor) : Value();
}

Value larger(const MotionMetrics& motion, Value HandMotion::*figure) {
  Value most;
  for (const HandMotion& hand : motion.hands) {
    if (hand.*figure && (!most || *(hand.*figure) > *most)) most = hand.*figure;
  }
  return most;
}

const Touches& touches(const MotionMetrics& motion, Partner partner) {
  return motion.touches[static_cast<std::size_t>(partner)];
}

Touches sum(const MotionMetrics& motion, const std::vector<Partner>& partners) {
  Touches all;
  for (const Partner partner : partners) {
    all.count += touches(motion, partner).count;
    all.ticks += touches(motion, partner).ticks;
  }
  return all;
}

/** The judge's count, by the exercise's rules. */
Value mistakes(const AttemptOutcome& outcome, Mistake mistake) {
  if (outcome.status == ExerciseStatus::kNone) return std::nullopt;
  return static_cast<double>(outcome.mistakes[static_cast<std::size_t>(mistake)]);
}

/** The judge's count, or, without one, that of all contacts. */
Value judged(const AttemptOutcome& outcome, Mistake mistake, std::uint64_t all) {
  const Value own = mistakes(outcome, mistake);
  return own ? own : Value(static_cast<double>(all));
}

constexpr std::initializer_list<Partner> kWalls{Partner::kTower, Partner::kDome, Partner::kPlate, Partner::kOther,
                                                Partner::kOtherArm};

/** The measured values, by the names of kMetrics, in any order. */
std::vector<std::pair<std::string, Value>> valuesOf(const MotionMetrics& motion,
                                                    const AttemptOutcome& outcome,
                                                    const Economy& economy) {
  const Touches wires = sum(motion, {Partner::kWire, Partner::kObjectWire});
  const Touches walls = sum(motion, kWalls);
  return {
      {"time", motion.duration},
      {"path", (motion.hands[0].path + motion.hands[1].path) * kMillimetres},
      {"economy", economy.ratio},
      {"off_path", scaled(economy.off_path, kMillimetres)},
      {"off_path_p95", scaled(economy.off_path_p95, kMillimetres)},
      {"idle", motion.idle},
      {"mean_jerk", overHands(motion, &HandMotion::mean_jerk)},
      {"sparc", overHands(motion, &HandMotion::sparc)},
      {"stroke_sparc", overHands(motion, &HandMotion::stroke_sparc)},
      {"ldlj", overHands(motion, &HandMotion::ldlj)},
      {"tremor", scaled(overHands(motion, &HandMotion::tremor), kMicrometres)},
      {"collisions", judged(outcome, Mistake::kCollision, walls.count)},
      {"collision_time", toSeconds(walls.ticks)},
      {"wire_touches", judged(outcome, Mistake::kWireTouch, wires.count)},
      {"wire_time", toSeconds(wires.ticks)},
      {"drops", mistakes(outcome, Mistake::kDrop)},
      {"break_offs", mistakes(outcome, Mistake::kBreakOff)},
      {"out_of_order", mistakes(outcome, Mistake::kOutOfOrder)},
      {"wrong_arm", mistakes(outcome, Mistake::kWrongArm)},
      {"peak_force", motion.contact_force.peak},
      {"force_p95", motion.contact_force.p95},
      {"force_impulse", motion.contact_force.impulse},
      {"force_above", toSeconds(motion.contact_force.above)},
      {"out_of_view", motion.out_of_view},
      {"clutches", static_cast<double>(motion.clutches)},
      {"clutch_time", motion.clutch_time},
      {"engaged", motion.engaged},
      {"camera_moves", static_cast<double>(motion.camera_moves)},
      {"camera_time", motion.camera_time},
      {"master_radius", scaled(larger(motion, &HandMotion::master_radius), kMillimetres)},
      {"master_deviation", scaled(larger(motion, &HandMotion::master_deviation), kMillimetres)},
      {"bimanual", motion.bimanual},
      {"speed_correlation", motion.speed_correlation},
      {"tracking", motion.tracking.count() > 0 ? Value(motion.tracking.mean() * kMillimetres) : std::nullopt},
  };
}

/** An attempt that fails before its timer starts has no tick of which something could be measured. */
bool hasBegun(const AttemptOutcome& outcome, const MotionMetrics& motion) {
  return outcome.status != ExerciseStatus::kFailed || motion.ticks > 0;
}

bool isAnsweredRightly(const HazardScore& hazard) {
  return hazard.response.verdict == Verdict::kRight;
}

bool isJudged(const HazardScore& hazard) {
  return hazard.response.verdict != Verdict::kNotJudged;
}

/** All that could be noticed. */
bool areAnswered(const AttemptScore& score) {
  return std::all_of(score.hazards.begin(), score.hazards.end(),
                     [](const HazardScore& hazard) { return !isJudged(hazard) || isAnsweredRightly(hazard); });
}

/** A drill in which there was nothing to answer proves nothing. */
bool hadItsDrill(const AttemptScore& score) {
  return !score.outcome.is_drill || std::any_of(score.hazards.begin(), score.hazards.end(), isJudged);
}

/** It failed, or nearly did; what cannot be better is no matter for advice. */
bool isWorthSaying(const MetricScore& score) {
  if (!score.is_judged) return false;
  const bool is_perfect = score.metric.better == Better::kLower && *score.metric.value <= 0.0;
  return !score.judgement.passed || (score.judgement.excess > -kNear && !is_perfect);
}

/** Failures by how far they are beyond their limits, then the passes that came near to them, the nearest first. */
std::vector<std::string> advise(const AttemptScore& score) {
  std::vector<const MetricScore*> order;
  for (const MetricScore& metric : score.metrics) {
    if (isWorthSaying(metric)) order.push_back(&metric);
  }
  std::stable_sort(order.begin(), order.end(), [](const MetricScore* a, const MetricScore* b) {
    if (a->judgement.passed != b->judgement.passed) return !a->judgement.passed;
    return a->judgement.excess > b->judgement.excess;
  });
  std::vector<std::string> advice;
  if (!areAnswered(score)) advice.push_back(kHazardMetric);
  for (const MetricScore* metric : order) {
    if (advice.size() < kMostAdvice) advice.push_back(metric->metric.name);
  }
  return advice;
}

/** The exercise's entry for a metric; nullptr without one. */
const ScoredMetric* findScored(const Standard& standard, const std::string& name) {
  if (!standard.scored) return nullptr;
  const auto is_it = [&](const ScoredMetric& metric) { return metric.name == name; };
  const auto found = std::find_if(standard.scored->begin(), standard.scored->end(), is_it);
  return found == standard.scored->end() ? nullptr : &*found;
}

/** By band or bound, of which there is one at least; where there are both by the stricter. */
BandJudgement judgeMetric(const MetricScore& score, const Standard& standard) {
  const double value = *score.metric.value;
  if (score.band == nullptr) return judgeByLimit(value, *score.bound, score.metric.better);
  const BandJudgement by_band = judge(value, *score.band, standard.band->least_spread, standard.deviations);
  if (!score.bound) return by_band;
  const double sign = score.band->better == Better::kLower ? 1.0 : -1.0;
  return sign * (*score.bound - by_band.limit) < 0.0 ? judgeByLimit(value, *score.bound, score.band->better) : by_band;
}

MetricScore scoreMetric(const Metric& metric, const Standard& standard) {
  MetricScore score;
  score.metric = metric;
  score.band = standard.band == nullptr ? nullptr : find(*standard.band, metric.name);
  const ScoredMetric* own = findScored(standard, metric.name);
  if (own != nullptr && own->has_limit != 0 && metric.name != kForceAbove) score.bound = own->limit;
  score.is_scored = standard.scored ? own != nullptr : score.band != nullptr;
  const bool can_be = standard.band != nullptr && (score.band != nullptr || score.bound);
  score.is_judged = score.is_scored && can_be && metric.value.has_value();
  if (score.is_judged) score.judgement = judgeMetric(score, standard);
  return score;
}

/** Of the exercise, or else of the band: that were not measured, are not in the band, or that nobody here knows. */
std::vector<std::string> unjudged(const Standard& standard, const std::vector<MetricScore>& metrics) {
  std::vector<std::string> names;
  const auto look = [&](const std::string& name) {
    const auto is_it = [&](const MetricScore& m) { return m.metric.name == name && m.is_judged; };
    if (std::none_of(metrics.begin(), metrics.end(), is_it)) names.push_back(name);
  };
  if (standard.scored) {
    for (const ScoredMetric& metric : *standard.scored)
      look(metric.name);
  } else {
    for (const BandMetric& metric : standard.band->metrics)
      look(metric.name);
  }
  return names;
}

void conclude(AttemptScore* score) {
  const auto is_judged = [](const MetricScore& m) { return m.is_judged; };
  const auto has_passed = [](const MetricScore& m) { return m.is_judged && m.judgement.passed; };
  const auto judged = std::count_if(score->metrics.begin(), score->metrics.end(), is_judged);
  const auto passed = std::count_if(score->metrics.begin(), score->metrics.end(), has_passed);
  if (judged > 0) score->composite = static_cast<double>(passed) / static_cast<double>(judged);
  if (score->outcome.status == ExerciseStatus::kNone) return;  // there was nothing to do
  const bool has_passed_all =
      judged > 0 && passed == judged && score->outcome.status == ExerciseStatus::kDone && areAnswered(*score);
  if (!has_passed_all || hadItsDrill(*score)) score->passed = has_passed_all;
}

}  // namespace

std::optional<double> firstAnswer(const std::vector<HazardScore>& hazards) {
  for (const HazardScore& hazard : hazards) {
    const HazardResponse& r = hazard.response;
    if (r.verdict == Verdict::kRight || r.verdict == Verdict::kLate) return toSeconds(r.deciding.after - r.cue_after);
  }
  return std::nullopt;
}

std::vector<Metric> listMetrics(const MotionMetrics& motion, const AttemptOutcome& outcome, const Economy& economy) {
  const auto values = valuesOf(motion, outcome, economy);
  std::vector<Metric> metrics;
  for (const MetricInfo& info : kMetrics) {
    const auto found = std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == info.name; });
    metrics.push_back({info.name, info.unit, info.group, info.better, found == values.end() ? Value() : found->second});
  }
  return metrics;
}

AttemptScore scoreAttempt(const AttemptOutcome& outcome,
                          const MotionMetrics& motion,
                          const Economy& economy,
                          const std::vector<HazardScore>& hazards,
                          const Standard& standard) {
  AttemptScore score;
  score.outcome = outcome;
  score.motion = motion;
  score.economy = economy;
  score.hazards = hazards;
  for (Metric metric : listMetrics(motion, outcome, economy)) {
    if (!hasBegun(outcome, motion)) metric.value.reset();
    score.metrics.push_back(scoreMetric(metric, standard));
  }
  if (standard.band != nullptr) {
    score.not_judged = unjudged(standard, score.metrics);
    conclude(&score);
  }
  score.improve = advise(score);
  return score;
}

}  // namespace raven2_trainer::training
