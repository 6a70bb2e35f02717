#include "training/attempt_collector.h"

#include <algorithm>
#include <utility>

namespace raven2_trainer::training {

AttemptCollector::AttemptCollector(const ScoreSettings& settings,
                                   const session::LogHeader& header,
                                   std::vector<TickSpan> answers)
    : settings_(settings.motion), tracks_(settings.tracks), header_(header), answers_(std::move(answers)) {}

/** While an exercise runs; without one from the first pedal-down. */
bool AttemptCollector::counts(const ModelState& model) const {
  if (!traitsOf(model.mode).timed) return false;
  if (model.exercise.status == ExerciseStatus::kNone) return !has_exercise_ && model.session_tick >= 0;
  return model.exercise.status == ExerciseStatus::kRunning;
}

bool AttemptCollector::isAnswering(Tick session_tick) const {
  return std::any_of(answers_.begin(), answers_.end(),
                     [&](const TickSpan& answer) { return session_tick >= answer.begin && session_tick < answer.end; });
}

/** An attempt that fails before its timer starts has no tick that counts, but is an attempt. */
bool AttemptCollector::begins(const ModelState& model) const {
  const bool has_failed = model.exercise.status == ExerciseStatus::kFailed && model.mode != Mode::kReplaying;
  return counts(model) || has_failed;
}

/** The newest, if it is the one that the state speaks of. */
CollectedAttempt* AttemptCollector::attemptOf(const ExerciseState& exercise) {
  if (attempts_.empty()) return nullptr;
  CollectedAttempt* newest = &attempts_.back();
  const bool is_free = exercise.status == ExerciseStatus::kNone;
  const bool was_free = newest->outcome.status == ExerciseStatus::kNone;
  if (is_free || was_free) return is_free && was_free ? newest : nullptr;
  return newest->outcome.number == exercise.attempt ? newest : nullptr;
}

CollectedAttempt* AttemptCollector::begin(const ModelState& model) {
  attempts_.push_back({{}, {}, MotionAccumulator(settings_), TransitCollector(settings_.X_WB, tracks_)});
  CollectedAttempt* attempt = &attempts_.back();
  attempt->outcome.number = model.exercise.status == ExerciseStatus::kNone ? 1 : model.exercise.attempt;
  attempt->outcome.first = counts(model) ? model.session_tick : -1;
  attempt->outcome.is_drill = header_.drill != "none";
  attempt->transits.begin(model.exercise);
  return attempt;
}

void AttemptCollector::add(const TickRecord& record) {
  const ModelState& model = record.model;
  const ExerciseState& exercise = model.exercise;
  has_exercise_ = has_exercise_ || exercise.status != ExerciseStatus::kNone;
  CollectedAttempt* attempt = attemptOf(exercise);
  if (attempt == nullptr && begins(model)) attempt = begin(model);
  if (attempt != nullptr) {
    attempt->outcome.status = exercise.status;
    attempt->outcome.failure = exercise.failure;
    attempt->outcome.steps = exercise.step > 0 ? exercise.step - 1 : 0;
    attempt->outcome.mistakes = exercise.mistakes;
    for (const ExerciseRecord& event : events_)
      note(event.event, attempt);
    if (counts(model)) {
      if (!isAnswering(model.session_tick)) {
        attempt->motion.add(record);
        attempt->transits.add(model);
      }
      attempt->outcome.last = model.session_tick;
    }
  }
  // Events before the timer starts belong to the attempt that waits for it.
  const bool waits = attempt == nullptr && exercise.status == ExerciseStatus::kWaiting;
  if (!waits) events_.clear();
}

void AttemptCollector::add(const ExerciseRecord& record) {
  if (record.event.kind == ExerciseEventKind::kStarted) events_.clear();  // of an attempt that never began
  events_.push_back(record);
}

void AttemptCollector::note(const ExerciseEvent& event, CollectedAttempt* attempt) const {
  attempt->transits.add(event);
  const double at = attempt->motion.duration();
  if (event.kind == ExerciseEventKind::kStepDone) {
    const bool is_named =
        event.track < header_.step_names.size() && event.step < header_.step_names[event.track].size();
    const std::string number = std::to_string(event.track) + "." + std::to_string(event.step);
    attempt->history.steps.push_back({is_named ? header_.step_names[event.track][event.step] : number, at});
  }
  if (event.kind == ExerciseEventKind::kMistake) {
    attempt->history.mistakes.push_back({kMistakeNames[static_cast<std::size_t>(event.mistake) % kMistakeCount], at});
  }
}

std::vector<CollectedAttempt> AttemptCollector::take() {
  std::vector<CollectedAttempt> all;
  for (CollectedAttempt& attempt : attempts_) {
    const bool is_free = attempt.outcome.status == ExerciseStatus::kNone;
    if (!(has_exercise_ && is_free)) all.push_back(std::move(attempt));
  }
  attempts_.clear();
  return all;
}

}  // namespace raven2_trainer::training
