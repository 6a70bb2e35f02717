#include <cstdio>
#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/training/session_score.h"
#include "training/json_values.h"
#include "training/units.h"

namespace raven2_trainer::training {

namespace {

constexpr int kScoreVersion = 1;
constexpr std::uintmax_t kMostScoreBytes = 64U << 20U;

Json nameOrNull(const std::string& name) {
  return name.empty() || name == "none" ? Json(nullptr) : Json(name);
}

Json describe(const MetricScore& score) {
  const Metric& metric = score.metric;
  const bool has_band = score.band != nullptr;
  return {{"value", orNull(metric.value)},
          {"unit", metric.unit},
          {"group", kMetricGroupNames[static_cast<std::size_t>(metric.group)]},
          {"better", kBetterNames[static_cast<std::size_t>(has_band ? score.band->better : metric.better)]},
          {"scored", score.is_scored},
          {"bound", orNull(score.bound)},
          {"mean", has_band ? Json(score.band->mean) : Json(nullptr)},
          {"deviation", has_band ? Json(score.band->deviation) : Json(nullptr)},
          {"limit", score.is_judged ? Json(score.judgement.limit) : Json(nullptr)},
          {"excess", score.is_judged ? Json(score.judgement.excess) : Json(nullptr)},
          {"passed", score.is_judged ? Json(score.judgement.passed) : Json(nullptr)}};
}

Json describe(const HandMotion& hand) {
  return {{"path_mm", hand.path * kMillimetres},
          {"mean_speed_mm_s", hand.mean_speed * kMillimetres},
          {"max_speed_mm_s", hand.max_speed * kMillimetres},
          {"active_time_s", hand.active_time},
          {"mean_jerk_m_s3", orNull(hand.mean_jerk)},
          {"sparc", orNull(hand.sparc)},
          {"dlj", orNull(hand.dlj)},
          {"ldlj", orNull(hand.ldlj)},
          {"stroke_sparc", orNull(hand.stroke_sparc)},
          {"strokes", hand.strokes},
          {"tremor_um", orNull(hand.tremor, kMicrometres)},
          {"master_radius_mm", orNull(hand.master_radius, kMillimetres)},
          {"master_deviation_mm", orNull(hand.master_deviation, kMillimetres)},
          {"out_of_view_s", orNull(hand.out_of_view)}};
}

Json describe(const std::array<Touches, kPartnerCount>& touches) {
  Json all = Json::object();
  for (std::size_t i = 0; i < kPartnerCount; ++i)
    all[kPartnerNames[i]] = {{"count", touches[i].count}, {"time_s", toSeconds(touches[i].ticks)}};
  return all;
}

Json describe(const ForceSummary& force) {
  return {{"peak_N", force.peak},
          {"p95_N", force.p95},
          {"impulse_Ns", force.impulse},
          {"above_s", toSeconds(force.above)},
          {"with_force_s", toSeconds(force.with_force)}};
}

Json describe(const TimedResponse& response) {
  if (response.response == Response::kNone) return nullptr;
  return {{"response", kResponseNames[static_cast<std::size_t>(response.response)]}, {"after_ms", response.after}};
}

Json describe(const HazardScore& hazard) {
  const HazardResponse& r = hazard.response;
  Json coincidences = Json::array();
  for (const TimedResponse& each : r.coincidences)
    coincidences.push_back(describe(each));
  return {{"scenario", hazard.scenario},
          {"injection_tick", hazard.injection},
          {"force_after_ms", orNull(r.force_after)},
          {"cue_after_ms", orNull(r.cue_after)},
          {"cue", r.sense == Sense::kNone ? Json(nullptr) : Json(kSenseNames[static_cast<std::size_t>(r.sense)])},
          {"reaction", describe(r.reaction)},
          {"deciding", describe(r.deciding)},
          {"verdict", kVerdictNames[static_cast<std::size_t>(r.verdict)]},
          {"answer_time_ms", r.answer_time},
          {"release_ms", r.release},
          {"release_needed_ms", r.release_needed},
          {"coincidences", coincidences},
          {"recovered", r.recovered},
          {"duration_ms", r.duration},
          {"excursion_mm", r.excursion * kMillimetres},
          {"error_mm", r.error * kMillimetres},
          {"peak_force_N", r.peak_force},
          {"impulse_Ns", r.impulse},
          {"touches", describe(r.touches)}};
}

Json describe(const std::vector<HazardScore>& hazards) {
  Json all = Json::array();
  for (const HazardScore& hazard : hazards)
    all.push_back(describe(hazard));
  return all;
}

Json describe(const std::vector<StepTime>& times) {
  Json all = Json::array();
  for (const StepTime& time : times)
    all.push_back({{"name", time.name}, {"at_s", time.at}});
  return all;
}

Json describeMistakes(const AttemptOutcome& outcome) {
  Json all = Json::object();
  for (std::size_t i = 0; i < kMistakeCount; ++i)
    all[kMistakeNames[i]] = outcome.mistakes[i];
  return all;
}

Json describeMetrics(const AttemptScore& score) {
  Json all = Json::object();
  for (const MetricScore& metric : score.metrics)
    all[metric.metric.name] = describe(metric);
  return all;
}

Json describe(const AttemptScore& score, const AttemptHistory& history) {
  const AttemptOutcome& outcome = score.outcome;
  const MotionMetrics& motion = score.motion;
  Json hands = Json::object();
  for (const Arm arm : kArms)
    hands[name(arm)] = describe(at(motion.hands, arm));
  return {{"number", outcome.number},
          {"status", kExerciseStatusNames[static_cast<std::size_t>(outcome.status)]},
          {"failure", kExerciseFailureNames[static_cast<std::size_t>(outcome.failure)]},
          {"first_tick", orNull(outcome.first)},
          {"last_tick", orNull(outcome.last)},
          {"passed", score.passed ? Json(*score.passed) : Json(nullptr)},
          {"composite", orNull(score.composite)},
          {"improve", score.improve},
          {"not_judged", score.not_judged},
          {"metrics", describeMetrics(score)},
          {"transits", score.economy.transits},
          {"transits_planned", score.economy.planned},
          {"steps_done", outcome.steps},
          {"steps", describe(history.steps)},
          {"mistakes", describeMistakes(outcome)},
          {"mistake_times", describe(history.mistakes)},
          {"hands", hands},
          {"touches", describe(motion.touches)},
          {"contact_force", describe(motion.contact_force)},
          {"haptic_force", describe(motion.haptic_force)},
          {"hazards", describe(score.hazards)}};
}

Json describeBand(const ScoreSettings& settings) {
  const Band* band = settings.standard.band;
  if (band == nullptr) return nullptr;
  return {{"origin", band->origin},
          {"sessions", band->sessions},
          {"least_spread", band->least_spread},
          {"file", settings.band_file.empty() ? Json(nullptr) : Json(settings.band_file)},
          {"deviations", settings.standard.deviations}};
}

Json describeRule(const ResponseRule& rule) {
  const auto names = [](const std::vector<Response>& responses) {
    Json all = Json::array();
    for (const Response response : responses)
      all.push_back(kResponseNames[static_cast<std::size_t>(response)]);
    return all;
  };
  return {{"right", names(rule.right)}, {"wrong", names(rule.wrong)}, {"within_s", rule.within}};
}

}  // namespace

void writeScore(const std::string& path, const SessionScore& score, const ScoreSettings& settings) {
  Json attempts = Json::array();
  for (std::size_t i = 0; i < score.attempts.size(); ++i)
    attempts.push_back(describe(score.attempts[i], score.histories[i]));
  const Json json = {{"version", kScoreVersion},
                     {"exercise", nameOrNull(score.header.exercise)},
                     {"drill", nameOrNull(score.header.drill)},
                     {"trainee", nameOrNull(score.header.trainee)},
                     {"curriculum", nameOrNull(score.header.curriculum)},
                     {"motion", score.header.motion},
                     {"motion_scale", orNull(settings.motion.motion_scale)},
                     {"force_limit_N", settings.motion.force_limit},
                     {"band", describeBand(settings)},
                     {"response_rule", describeRule(settings.response)},
                     {"attempts", attempts},
                     {"hazards", describe(score.hazards)},
                     {"hazards_beyond", score.hazards_beyond}};
  const std::string draft = path + ".part";  // renamed, so that a reader never meets half a file
  std::ofstream file(draft);
  file << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  file.close();
  if (!file || std::rename(draft.c_str(), path.c_str()) != 0) throw SessionException(path + ": cannot be written");
}

std::map<std::int64_t, AttemptVerdict> readVerdicts(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kMostScoreBytes) throw SessionException(path + ": not a score.json of at most 64 MiB");
  std::ifstream file(path);
  std::map<std::int64_t, AttemptVerdict> verdicts;
  try {
    const Json json = Json::parse(file);
    for (const Json& attempt : json.at("attempts")) {
      AttemptVerdict verdict;
      if (!attempt.at("passed").is_null()) verdict.passed = attempt.at("passed").get<bool>();
      if (!attempt.at("composite").is_null()) verdict.composite = attempt.at("composite").get<double>();
      verdicts[attempt.at("number").get<std::int64_t>()] = verdict;
    }
  } catch (const Json::exception& e) {
    throw SessionException(path + ": " + e.what());
  }
  return verdicts;
}

}  // namespace raven2_trainer::training
