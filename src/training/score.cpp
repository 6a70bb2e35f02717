#include "raven2_trainer/training/score.h"

#include <algorithm>

namespace raven2_trainer::training {

namespace {

constexpr double kMillimetres = 1e3;  // in a metre
constexpr double kMicrometres = 1e6;  // in a metre
constexpr std::size_t kMostAdvice = 3;

using Value = std::optional<double>;

Value scaled(const Value& value, double factor) {
  return value ? Value(*value * factor) : Value();
}

double seconds(Tick ticks) {
  return static_cast<double>(ticks) * kTickSeconds;
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

/** What the judge counted, by the exercise's own rules. */
Value mistakes(const AttemptOutcome& outcome, Mistake mistake) {
  if (outcome.status == ExerciseStatus::kNone) return std::nullopt;
  return static_cast<double>(outcome.mistakes[static_cast<std::size_t>(mistake)]);
}

/** The judge's count, or, without one, that of all contacts. */
Value judged(const AttemptOutcome& outcome, Mistake mistake, std::uint64_t all) {
  const Value own = mistakes(outcome, mistake);
  return own ? own : Value(static_cast<double>(all));
}

class MetricList {
 public:
  MetricList(MetricGroup group, std::vector<Metric>* metrics) : group_(group), metrics_(metrics) {}
  MetricList& lower(const char* name, const char* unit, Value value) {
    metrics_->push_back({name, unit, group_, Better::kLower, value});
    return *this;
  }
  MetricList& higher(const char* name, const char* unit, Value value) {
    metrics_->push_back({name, unit, group_, Better::kHigher, value});
    return *this;
  }

 private:
  MetricGroup group_;
  std::vector<Metric>* metrics_;
};

void listEfficiency(const MotionMetrics& motion, const Economy& economy, std::vector<Metric>* metrics) {
  MetricList(MetricGroup::kEfficiency, metrics)
      .lower("time", "s", motion.duration)
      .lower("path", "mm", (motion.hands[0].path + motion.hands[1].path) * kMillimetres)
      .higher("economy", "-", economy.ratio)
      .lower("off_path", "mm", scaled(economy.off_path, kMillimetres))
      .lower("off_path_p95", "mm", scaled(economy.off_path_p95, kMillimetres))
      .lower("idle", "-", motion.idle)
      .lower("mean_jerk", "m/s^3", overHands(motion, &HandMotion::mean_jerk))
      .higher("sparc", "-", overHands(motion, &HandMotion::sparc))
      .higher("stroke_sparc", "-", overHands(motion, &HandMotion::stroke_sparc))
      .higher("ldlj", "-", overHands(motion, &HandMotion::ldlj))
      .lower("tremor", "um", scaled(overHands(motion, &HandMotion::tremor), kMicrometres));
}

void listSafety(const MotionMetrics& motion, const AttemptOutcome& outcome, std::vector<Metric>* metrics) {
  const Touches wires = sum(motion, {Partner::kWire, Partner::kObjectWire});
  const Touches walls =
      sum(motion, {Partner::kTower, Partner::kDome, Partner::kPlate, Partner::kOther, Partner::kOtherArm});
  MetricList(MetricGroup::kSafety, metrics)
      .lower("collisions", "count", judged(outcome, Mistake::kCollision, walls.count))
      .lower("collision_time", "s", seconds(walls.ticks))
      .lower("wire_touches", "count", judged(outcome, Mistake::kWireTouch, wires.count))
      .lower("wire_time", "s", seconds(wires.ticks))
      .lower("drops", "count", mistakes(outcome, Mistake::kDrop))
      .lower("break_offs", "count", mistakes(outcome, Mistake::kBreakOff))
      .lower("out_of_order", "count", mistakes(outcome, Mistake::kOutOfOrder))
      .lower("wrong_arm", "count", mistakes(outcome, Mistake::kWrongArm))
      .lower("peak_force", "N", motion.contact_force.peak)
      .lower("force_p95", "N", motion.contact_force.p95)
      .lower("force_impulse", "Ns", motion.contact_force.impulse)
      .lower("force_above", "s", seconds(motion.contact_force.above))
      .lower("out_of_view", "s", motion.out_of_view);
}

void listControl(const MotionMetrics& motion, std::vector<Metric>* metrics) {
  MetricList(MetricGroup::kControl, metrics)
      .lower("clutches", "count", static_cast<double>(motion.clutches))
      .lower("clutch_time", "s", motion.clutch_time)
      .higher("engaged", "-", motion.engaged)
      .lower("camera_moves", "count", static_cast<double>(motion.camera_moves))
      .lower("camera_time", "s", motion.camera_time)
      .lower("master_radius", "mm", scaled(larger(motion, &HandMotion::master_radius), kMillimetres))
      .lower("master_deviation", "mm", scaled(larger(motion, &HandMotion::master_deviation), kMillimetres))
      .higher("bimanual", "-", motion.bimanual)
      .higher("speed_correlation", "-", motion.speed_correlation)
      .lower("tracking", "mm",
             motion.tracking.count() > 0 ? Value(motion.tracking.mean() * kMillimetres) : std::nullopt);
}

bool isAnsweredRightly(const HazardScore& hazard) {
  return hazard.response.verdict == Verdict::kRight;
}

/** Failures by how far they are beyond their limits, then the passes that came nearest to them. */
std::vector<std::string> advise(const AttemptScore& score) {
  std::vector<const MetricScore*> order;
  for (const MetricScore& metric : score.metrics) {
    if (metric.is_judged) order.push_back(&metric);
  }
  std::stable_sort(order.begin(), order.end(), [](const MetricScore* a, const MetricScore* b) {
    if (a->judgement.passed != b->judgement.passed) return !a->judgement.passed;
    return a->judgement.excess > b->judgement.excess;
  });
  std::vector<std::string> advice;
  if (!std::all_of(score.hazards.begin(), score.hazards.end(), isAnsweredRightly)) advice.push_back(kHazardMetric);
  for (const MetricScore* metric : order) {
    if (advice.size() < kMostAdvice) advice.push_back(metric->metric.name);
  }
  return advice;
}

MetricScore scoreMetric(const Metric& metric, const Band* band, double deviations) {
  MetricScore score;
  score.metric = metric;
  score.band = band == nullptr ? nullptr : find(*band, metric.name);
  score.is_judged = score.band != nullptr && metric.value.has_value();
  if (score.is_judged) score.judgement = judge(*metric.value, *score.band, band->least_spread, deviations);
  return score;
}

/** Names of the band that were not measured, or that this program does not know. */
std::vector<std::string> unjudged(const Band& band, const std::vector<MetricScore>& metrics) {
  std::vector<std::string> names;
  for (const BandMetric& metric : band.metrics) {
    const auto is_it = [&](const MetricScore& m) { return m.metric.name == metric.name && m.is_judged; };
    if (std::none_of(metrics.begin(), metrics.end(), is_it)) names.push_back(metric.name);
  }
  return names;
}

void conclude(AttemptScore* score) {
  const auto is_judged = [](const MetricScore& m) { return m.is_judged; };
  const auto has_passed = [](const MetricScore& m) { return m.is_judged && m.judgement.passed; };
  const auto judged = std::count_if(score->metrics.begin(), score->metrics.end(), is_judged);
  const auto passed = std::count_if(score->metrics.begin(), score->metrics.end(), has_passed);
  if (judged > 0) score->composite = static_cast<double>(passed) / static_cast<double>(judged);
  const bool is_struck = !score->outcome.is_drill || !score->hazards.empty();
  score->passed = judged > 0 && passed == judged && score->outcome.status == ExerciseStatus::kDone && is_struck &&
                  std::all_of(score->hazards.begin(), score->hazards.end(), isAnsweredRightly);
}

}  // namespace

std::vector<Metric> listMetrics(const MotionMetrics& motion, const AttemptOutcome& outcome, const Economy& economy) {
  std::vector<Metric> metrics;
  listEfficiency(motion, economy, &metrics);
  listSafety(motion, outcome, &metrics);
  listControl(motion, &metrics);
  return metrics;
}

AttemptScore scoreAttempt(const AttemptOutcome& outcome,
                          const MotionMetrics& motion,
                          const Economy& economy,
                          const std::vector<HazardScore>& hazards,
                          const Band* band,
                          double deviations) {
  AttemptScore score;
  score.outcome = outcome;
  score.motion = motion;
  score.economy = economy;
  score.hazards = hazards;
  for (const Metric& metric : listMetrics(motion, outcome, economy))
    score.metrics.push_back(scoreMetric(metric, band, deviations));
  if (band != nullptr) {
    score.not_judged = unjudged(*band, score.metrics);
    conclude(&score);
  }
  score.improve = advise(score);
  return score;
}

}  // namespace raven2_trainer::training
