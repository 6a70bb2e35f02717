#include "raven2_trainer/recording/finish_session.h"

#include <cstdio>
#include <exception>
#include <filesystem>

#include "raven2_trainer/config/load_band.h"
#include "raven2_trainer/config/load_curriculum.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/recording/format.h"
#include "raven2_trainer/recording/merge_truth.h"
#include "raven2_trainer/recording/reference_paths.h"
#include "raven2_trainer/recording/resimulation.h"
#include "raven2_trainer/session/recovery.h"
#include "raven2_trainer/training/metric_names.h"

namespace raven2_trainer::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kAskEvery = 100;  // [ticks] whether it is to be given up
constexpr std::size_t kMostPlans = 300;   // of a session: an hour of work, and half a minute of planning

std::shared_ptr<const Band> loadBand(const TrainerConfig& config, const ScoringOptions& options) {
  if (!options.band.empty()) return std::make_shared<const Band>(config::loadBand(options.band));
  if (config.exercise_name == "none") return nullptr;
  const std::optional<Band> band = config::findBand(config.bands, config.exercise_name);
  return band ? std::make_shared<const Band>(*band) : nullptr;
}

/** [N] That force_above compares with. */
double forceLimit(const Exercise& exercise, double otherwise) {
  for (const ScoredMetric& metric : exercise.metrics) {
    if (metric.name == kForceAbove && metric.has_limit != 0) return metric.limit;
  }
  return otherwise;
}

training::MotionSettings motionSettings(const TrainerConfig& config, const session::LogHeader& header) {
  training::MotionSettings settings;
  for (const Arm arm : kArms)
    at(settings.X_WB, arm) = Pose{model::armBaseRotation(arm), toEigen(at(config.arms.rcm_W, arm))};
  settings.bodies = training::classifyBodies(header.body_names, config.roles);
  for (const CameraConfig& camera : config.render.cameras) {
    if (camera.name == header.camera.name) settings.camera = camera;
  }
  settings.image_width = config.render.live_width;
  settings.image_height = config.render.live_height;
  if (header.motion_scale > 0.0) settings.motion_scale = header.motion_scale;
  settings.force_limit = forceLimit(config.exercise, settings.force_limit);
  return settings;
}

ConsoleConfig handOf(const TrainerConfig& config, const session::LogHeader& header) {
  ConsoleConfig hand = config.console;
  hand.hand_mass = header.hand.mass;
  hand.hand_stiffness = header.hand.stiffness;
  hand.hand_damping = header.hand.damping;
  return hand;
}

/** In a drill, of whatever scenario, the exercise's; else nobody says what is right. */
training::ResponseRule responseRule(const TrainerConfig& config) {
  const ExerciseDrill& drill = config.exercise.drill;
  const bool is_said = config.drill != "none" && !drill.scenario.empty();
  return is_said ? training::ruleOf(drill) : training::ResponseRule{};
}

training::ScoreSettings scoreSettings(const TrainerConfig& config,
                                      const session::LogHeader& header,
                                      const ScoredSession& scored) {
  training::ScoreSettings settings;
  settings.motion = motionSettings(config, header);
  settings.tracks = config.exercise.tracks;
  settings.hand = handOf(config, header);
  settings.response = responseRule(config);
  settings.standard.band = scored.band.get();
  if (scored.curriculum) settings.standard.deviations = scored.curriculum->deviations;
  if (config.exercise_name != "none") settings.standard.scored = config.exercise.metrics;
  return settings;
}

std::string orEmpty(const std::string& name) {
  return name == "none" ? "" : name;
}

training::IndexAttempt describeBriefly(const training::AttemptScore& attempt) {
  training::IndexAttempt brief;
  brief.status = kExerciseStatusNames[static_cast<std::size_t>(attempt.outcome.status)];
  brief.passed = attempt.passed;
  for (const training::MetricScore& metric : attempt.metrics) {
    if (metric.metric.value) brief.metrics[metric.metric.name] = *metric.metric.value;
  }
  if (const auto answer = training::firstAnswer(attempt.hazards)) brief.metrics[training::kHazardMetric] = *answer;
  return brief;
}

training::IndexEntry indexEntry(const std::string& directory, const ScoredSession& scored) {
  training::IndexEntry entry;
  entry.directory = fs::canonical(directory).filename().string();
  entry.start_time_utc = session::readStartTime({directory});
  entry.trainee = scored.trainee;
  entry.exercise = orEmpty(scored.score.header.exercise);
  entry.drill = orEmpty(scored.score.header.drill);
  for (const training::AttemptScore& attempt : scored.score.attempts)
    entry.attempts.push_back(describeBriefly(attempt));
  return entry;
}

/** Enters the session, and looks what the trainee did so far. */
void keep(const std::string& directory, const ScoringOptions& options, ScoredSession* scored) {
  scored->trainee = scored->score.header.trainee;
  if (options.no_index || scored->trainee.empty()) return;
  scored->index =
      !options.index.empty() ? options.index : (fs::canonical(directory).parent_path() / "index.json").string();
  const training::IndexEntry own = indexEntry(directory, *scored);
  training::addToIndex(scored->index, own);
  const std::vector<training::IndexEntry> index = training::readIndex(scored->index);
  for (const training::IndexEntry& entry : index) {
    if (entry.trainee == own.trainee && entry.exercise == own.exercise && entry.drill == own.drill)
      scored->history.push_back(entry);
  }
  if (scored->curriculum)
    scored->progress = training::follow(*scored->curriculum, training::attemptsOf(index, own.trainee));
}

// ---- for a terminal

const char* statusName(const training::AttemptScore& attempt) {
  return kExerciseStatusNames[static_cast<std::size_t>(attempt.outcome.status)];
}

std::string describeOutcome(const training::AttemptScore& attempt) {
  const char* verdict = !attempt.passed ? "not judged" : *attempt.passed ? "passed" : "not passed";
  std::string text = format("attempt %lld: %s", static_cast<long long>(attempt.outcome.number), statusName(attempt));
  if (attempt.outcome.failure != ExerciseFailure::kNone)
    text += format(" (%s)", kExerciseFailureNames[static_cast<std::size_t>(attempt.outcome.failure)]);
  return text + ", " + verdict;
}

std::string describeMetric(const training::MetricScore& metric) {
  const std::string& name = metric.metric.name;
  if (!metric.metric.value) return "";
  std::string text = format("  %-18s %12.4f %-6s", name.c_str(), *metric.metric.value, metric.metric.unit.c_str());
  if (metric.is_judged) {
    const Better better = metric.band != nullptr ? metric.band->better : metric.metric.better;
    text += format(" %s %.4f: %s", better == Better::kLower ? "<=" : ">=", metric.judgement.limit,
                   metric.judgement.passed ? "passed" : "NOT PASSED");
  }
  return text + "\n";
}

std::string describeAttempt(const training::AttemptScore& attempt) {
  std::string text = describeOutcome(attempt) + "\n";
  for (const training::MetricScore& metric : attempt.metrics)
    text += describeMetric(metric);
  for (const std::string& name : attempt.not_judged)
    text += format("  %-18s not measured or not in the band, so not judged\n", name.c_str());
  for (const std::string& advice : attempt.improve)
    text += "  work on: " + advice + "\n";
  return text;
}

std::string describeHazard(const training::HazardScore& hazard) {
  const training::HazardResponse& r = hazard.response;
  std::string text =
      format("hazard %s at %.3f s: %s", hazard.scenario.c_str(), static_cast<double>(hazard.injection) * kTickSeconds,
             training::kVerdictNames[static_cast<std::size_t>(r.verdict)]);
  if (r.reaction.after >= 0) {
    text += format(", %s after %lld ms", training::kResponseNames[static_cast<std::size_t>(r.reaction.response)],
                   static_cast<long long>(r.reaction.after));
  }
  return text + "\n";
}

std::string figure(const training::IndexAttempt& attempt, const char* metric) {
  const auto found = attempt.metrics.find(metric);
  return found == attempt.metrics.end() ? format("%10s", "-") : format("%10.2f", found->second);
}

/** Newest last; long ones from where they still fit a screen. */
std::string describeCurve(const ScoredSession& scored) {
  constexpr std::size_t kMostRows = 20;
  std::vector<std::string> rows;
  for (const training::IndexEntry& entry : scored.history) {
    for (const training::IndexAttempt& attempt : entry.attempts) {
      const char* verdict = !attempt.passed ? "not judged" : *attempt.passed ? "passed" : "not passed";
      rows.push_back(
          format("  %3zu  %-20s %-8s", rows.size() + 1, entry.start_time_utc.c_str(), attempt.status.c_str()) +
          figure(attempt, "time") + figure(attempt, "path") + figure(attempt, "economy") + figure(attempt, "sparc") +
          "  " + verdict + "\n");
    }
  }
  if (rows.empty()) return "";
  std::string text = format("%s so far:\n       %-20s %-8s%10s%10s%10s%10s\n", scored.trainee.c_str(), "began", "",
                            "time [s]", "path [mm]", "economy", "sparc");
  for (std::size_t i = rows.size() > kMostRows ? rows.size() - kMostRows : 0; i < rows.size(); ++i)
    text += rows[i];
  return text;
}

std::string describeProgress(const Curriculum& curriculum, const training::Progress& progress) {
  std::string text =
      format("%s: %zu of %zu stages done\n", curriculum.title.c_str(), progress.current, curriculum.stages.size());
  for (std::size_t i = 0; i < curriculum.stages.size(); ++i) {
    const CurriculumStage& stage = curriculum.stages[i];
    const training::StageProgress& own = progress.stages[i];
    const std::string drill = stage.drill.empty() ? "" : " with " + stage.drill;
    text += format("%s %s%s: %lld of %lld in a row", i == progress.current ? ">" : " ", stage.exercise.c_str(),
                   drill.c_str(), static_cast<long long>(own.in_a_row), static_cast<long long>(stage.passes));
    if (stage.extra > 0)
      text += format(", %lld of %lld more", static_cast<long long>(own.extra), static_cast<long long>(stage.extra));
    text += "\n";
  }
  return text;
}

void report(const ScoredSession& scored) {
  const std::string& exercise = scored.score.header.exercise;
  if (scored.score.attempts.empty()) std::fprintf(stderr, "%s: it never began\n", exercise.c_str());
  for (const training::AttemptScore& attempt : scored.score.attempts)
    std::fprintf(stderr, "%s: %s\n", exercise.c_str(), describeOutcome(attempt).c_str());
  if (!scored.progress) return;
  std::fprintf(stderr, "%s: %zu of %zu stages done\n", scored.curriculum->title.c_str(), scored.progress->current,
               scored.curriculum->stages.size());
}

}  // namespace

ScoredSession scoreRecorded(const std::string& directory, const ScoringOptions& options) {
  if (!options.trainee.empty() && !training::isTraineeId(options.trainee))  // before anything is written
    throw SessionException("trainee \"" + options.trainee.substr(0, 40) + "\": expected 1 to 32 of a-z, 0-9, _ and -");
  const session::SessionPaths paths = session::openSessionDirectory(directory);
  const TrainerConfig config = sessionConfig(paths);
  ScoredSession scored;
  scored.path = options.output.empty() ? paths.score() : options.output;
  scored.band = loadBand(config, options);
  if (config.curriculum != "none") scored.curriculum = config::findCurriculum(config.curricula, config.curriculum);
  training::ScoreSettings settings = scoreSettings(config, session::readLogHeader(paths.log()), scored);
  if (!options.band.empty()) settings.band_file = fs::absolute(options.band).string();
  const auto giveUpIfAsked = [&] {
    if (options.cancelled && options.cancelled()) throw ScoringCancelled{};
  };
  std::uint64_t ticks = 0;
  settings.on_tick = [&] {
    if (++ticks % kAskEvery == 0) giveUpIfAsked();
  };
  std::optional<ReferencePaths> reference;  // costs memory and time where nothing was carried
  std::size_t plans = 0;
  settings.plan = [&](const training::Transit& transit) {
    giveUpIfAsked();
    if (++plans > kMostPlans) return std::vector<Vec3>{};
    if (!reference) reference.emplace(config);
    return reference->plan(transit);
  };
  scored.score = training::scoreSession(paths.log(), settings);
  if (!options.trainee.empty()) scored.score.header.trainee = options.trainee;
  training::writeScore(scored.path, scored.score, settings);
  keep(directory, options, &scored);
  return scored;
}

std::string describe(const ScoredSession& scored) {
  std::string text;
  for (const training::AttemptScore& attempt : scored.score.attempts)
    text += describeAttempt(attempt);
  for (const training::HazardScore& hazard : scored.score.hazards)
    text += describeHazard(hazard);
  text += describeCurve(scored);
  if (scored.progress) text += describeProgress(*scored.curriculum, *scored.progress);
  return text;
}

bool lacksScore(const session::SessionPaths& paths) noexcept {
  try {
    if (!fs::is_regular_file(paths.log()) || fs::exists(paths.score()) || session::isUnclean(paths)) return false;
    const session::LogHeader header = session::readLogHeader(paths.log());
    return header.exercise != "none" && header.model_version == kModelVersion;
  } catch (const std::exception&) {
    return false;
  }
}

bool finishSession(const session::SessionPaths& paths, const std::function<bool()>& cancelled) noexcept {
  mergeTruthIfThere(paths);
  try {
    if (session::readLogHeader(paths.log()).exercise == "none") return true;
    ScoringOptions options;
    options.cancelled = cancelled;
    report(scoreRecorded(paths.directory, options));
    return true;
  } catch (const ScoringCancelled&) {
    std::fprintf(stderr, "%s: not scored: given up; score_session scores it\n", paths.directory.c_str());
    return false;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: cannot be scored: %s\n", paths.directory.c_str(), e.what());
    return false;
  }
}

}  // namespace raven2_trainer::recording
