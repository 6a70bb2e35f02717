#include "render/overlay_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::render {

namespace {

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[96];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

const char* modeName(Mode mode) noexcept {
  const auto i = static_cast<std::size_t>(mode);
  return i < kModeCount ? kModeNames[i] : "?";
}

const char* runLevelName(RunLevel level) noexcept {
  const auto i = static_cast<std::size_t>(level);
  return i < kRunLevelNames.size() ? kRunLevelNames[i] : "?";
}

std::string timeLine(const ModelState& model) {
  if (model.session_tick < 0) return "time      before pedal down";
  return format("time   %9.3f s", static_cast<double>(model.session_tick) * kTickSeconds);
}

std::string robotLine(const Snapshot& snapshot) {
  if (snapshot.robot.frame == 0) return "robot     none";
  return format("robot     %s%s", runLevelName(snapshot.robot.runlevel), snapshot.model.robot_fresh ? "" : " STALE");
}

std::string errorLine(const Snapshot& snapshot, Arm arm) {
  const double error = tipError(snapshot, arm);
  if (!std::isfinite(error)) return format("%-5s error     -", name(arm));
  return format("%-5s error %7.2f mm", name(arm), error * 1e3);
}

double norm(const Vec3& v) noexcept {
  return toEigen(v).norm();
}

void addStatus(const Snapshot& snapshot, std::vector<std::string>* lines) {
  lines->push_back(timeLine(snapshot.model));
  lines->push_back(format("mode      %s", modeName(snapshot.model.mode)));
  lines->push_back(robotLine(snapshot));
  lines->push_back(format("pedal     %s%s", snapshot.model.pedal != 0 ? "down" : "up",
                          snapshot.model.engaged != 0 ? "" : ", disengaged"));
  for (const Arm arm : kArms)
    lines->push_back(errorLine(snapshot, arm));
}

/** Age of the robot's state in the picture. It includes the part of its delay that exceeds the shortest one. */
std::string latencyLine(const Snapshot& snapshot, double stale_after) {
  if (snapshot.robot.frame == 0) return "latency   -";
  const double age =
      (static_cast<double>(snapshot.model.time_ns) - static_cast<double>(snapshot.robot.received_ns)) * 1e-9;
  return format("latency   %.1f ms%s", std::clamp(age, 0.0, 99.999) * 1e3, age > stale_after ? " STALE" : "");
}

std::string words(const char* name) {
  std::string text = name;
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string mistakesText(const ExerciseState& exercise) {
  std::uint64_t sum = 0;
  for (const std::uint32_t count : exercise.mistakes)
    sum += count;
  return format("%llu mistake%s", static_cast<unsigned long long>(sum), sum == 1 ? "" : "s");
}

/** [s] of the attempt, up to its end. */
double timeOf(const ModelState& model) {
  const ExerciseState& exercise = model.exercise;
  if (exercise.began < 0) return 0.0;
  const Tick now = exercise.ended >= exercise.began ? exercise.ended : model.tick;
  return std::clamp(static_cast<double>(now) - static_cast<double>(exercise.began), 0.0, 1e9) * kTickSeconds;
}

std::string attemptText(const ExerciseState& exercise, std::uint32_t steps) {
  const auto failure = static_cast<std::size_t>(exercise.failure);
  switch (exercise.status) {
    case ExerciseStatus::kWaiting:
      return "waiting";
    case ExerciseStatus::kRunning:
      return steps > 0 ? format("step %u of %u", std::min(exercise.step, steps), steps)
                       : format("step %u", exercise.step);
    case ExerciseStatus::kDone:
      return "done";
    case ExerciseStatus::kFailed:
      return "failed: " + (failure < kExerciseFailureCount ? words(kExerciseFailureNames[failure]) : "?");
    default:
      return "?";
  }
}

/** Of an attempt that is over. */
std::string verdictText(const Snapshot& snapshot) {
  const ExerciseStatus status = snapshot.model.exercise.status;
  if (status != ExerciseStatus::kDone && status != ExerciseStatus::kFailed) return "";
  const training::AttemptVerdict& verdict = snapshot.verdict;
  std::string text;
  if (verdict.passed) text = *verdict.passed ? ", passed" : ", not passed";
  if (verdict.composite && std::isfinite(*verdict.composite))
    text += format(", score %.0f %%", 100.0 * std::clamp(*verdict.composite, 0.0, 1.0));
  return text;
}

void addExercise(const Snapshot& snapshot, std::uint32_t steps, std::vector<std::string>* lines) {
  const ModelState& model = snapshot.model;
  if (model.exercise.status == ExerciseStatus::kNone) return;
  lines->push_back("exercise  " + attemptText(model.exercise, steps) + verdictText(snapshot));
  const std::string time = model.exercise.began < 0 ? "not begun" : format("%.1f s", timeOf(model));
  lines->push_back("          " + time + ", " + mistakesText(model.exercise));
}

/** Effect of a video fault on the trainee's picture. */
std::string pictureText(const DaemonFaults& faults) {
  switch (static_cast<PictureFault>(faults.picture)) {
    case PictureFault::kBlack:
      return "picture black";
    case PictureFault::kFrozen:
      return "picture frozen";
    case PictureFault::kEyesSwapped:
      return "eyes swapped";
    default:
      return faults.picture_delay_ms > 0 ? format("picture %u ms late", faults.picture_delay_ms) : "";
  }
}

/** Of an attempt that ended badly. */
std::string failureText(const ExerciseState& exercise) {
  if (exercise.status != ExerciseStatus::kFailed) return "";
  const auto failure = static_cast<std::size_t>(exercise.failure);
  return "ATTEMPT FAILED: " + (failure < kExerciseFailureCount ? words(kExerciseFailureNames[failure]) : "?");
}

std::string bannerText(const Snapshot& snapshot) {
  if (snapshot.fault.empty()) return "";
  const std::string picture = pictureText(snapshot.model.faults);
  return "FAULT: " + snapshot.fault + (picture.empty() ? "" : ", " + picture);
}

/** The most important of the lines, for a small picture. */
std::vector<std::string> briefLines(const Snapshot& snapshot, const SceneOptions& options) {
  const ModelState& model = snapshot.model;
  std::vector<std::string> lines;
  if (options.overlays.has(OverlayKind::kStatus)) {
    const bool is_stale = snapshot.robot.frame != 0 && !snapshot.model.robot_fresh;
    lines.push_back(words(modeName(model.mode)) + (is_stale ? ", robot STALE" : ""));
  }
  if (snapshot.is_substitute) lines.emplace_back("camera STALE");
  if (options.overlays.has(OverlayKind::kTimer) && model.exercise.status != ExerciseStatus::kNone) {
    lines.push_back(attemptText(model.exercise, options.exercise_steps) + format(", %.0f s, ", timeOf(model)) +
                    mistakesText(model.exercise));
  }
  return lines;
}

}  // namespace

double tipError(const Snapshot& snapshot, Arm arm) noexcept {
  if (snapshot.robot.frame == 0) return std::numeric_limits<double>::quiet_NaN();
  return (toEigen(at(snapshot.model.arms, arm).p_BT) - toEigen(at(snapshot.robot.arms, arm).p_BT)).norm();
}

Overlay describe(const Snapshot& snapshot, const SceneOptions& options) {
  Overlay overlay;
  const OverlaySet shown = options.overlays;
  if (shown.has(OverlayKind::kStatus)) addStatus(snapshot, &overlay.lines);
  if (snapshot.is_substitute) overlay.lines.emplace_back("camera    STALE, virtual scene");
  if (shown.has(OverlayKind::kLatency)) overlay.lines.push_back(latencyLine(snapshot, options.stale_after));
  if (shown.has(OverlayKind::kTimer)) addExercise(snapshot, options.exercise_steps, &overlay.lines);
  overlay.brief = briefLines(snapshot, options);
  overlay.has_bars = shown.has(OverlayKind::kForceBars);
  for (const Arm arm : kArms)
    at(overlay.force, arm) = norm(at(snapshot.haptic.force_B, arm));
  overlay.max_force = options.haptics.max_force;
  if (shown.has(OverlayKind::kHazard)) overlay.banner = bannerText(snapshot);
  if (shown.has(OverlayKind::kTimer) && overlay.banner.empty()) overlay.banner = failureText(snapshot.model.exercise);
  return overlay;
}

}  // namespace raven2_trainer::render
