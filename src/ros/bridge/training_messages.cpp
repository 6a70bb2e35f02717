#include "ros/bridge/training_messages.h"

#include <tuple>

#include "ros/node/name_of.h"

namespace raven2_trainer::ros_bridge {
namespace {

bool isDone(const ExerciseState& state, const Exercise& exercise, std::size_t track) {
  return state.done[track] >= exercise.tracks[track].steps.size();
}

/** Name of the step that a track waits for; empty if it is done, or waits for another track. */
std::string currentStep(const ExerciseState& state, const Exercise& exercise, std::size_t track) {
  const ExerciseTrack& t = exercise.tracks[track];
  const bool has_turn = t.after == kNobody || isDone(state, exercise, t.after);
  return has_turn && !isDone(state, exercise, track) ? t.steps[state.done[track]].name : "";
}

/** [s] Timer of an attempt. */
double elapsed(const ExerciseState& state, Tick now) {
  if (state.began < 0) return 0.0;
  return static_cast<double>((state.ended >= 0 ? state.ended : now) - state.began) * kTickSeconds;
}

bool hasMistake(ExerciseEventKind kind) {
  return kind == ExerciseEventKind::kMistake || kind == ExerciseEventKind::kDropped ||
         kind == ExerciseEventKind::kTouchBegan || kind == ExerciseEventKind::kTouchEnded;
}

bool hasArm(ExerciseEventKind kind) {
  return kind == ExerciseEventKind::kHeld || kind == ExerciseEventKind::kReleased ||
         kind == ExerciseEventKind::kMistake;
}

std::string bodyName(const std::vector<std::string>& names, std::uint16_t body) {
  return body < names.size() ? names[body] : "";
}

void nameStep(const ExerciseEvent& event, const Exercise& exercise, ExerciseEventStamped* message) {
  if (event.track >= exercise.tracks.size()) return;
  const ExerciseTrack& track = exercise.tracks[event.track];
  message->track = track.name;
  if (event.step < track.steps.size()) message->step = track.steps[event.step].name;
}

}  // namespace

TrainerMode trainerMode(const ModelState& model, const ros::Time& stamp) {
  TrainerMode message;
  message.header.stamp = stamp;
  message.mode = nameOf(kModeNames, model.mode);
  message.pedal = model.pedal != 0;
  message.engaged = model.engaged != 0;
  message.linked = model.linked != 0;
  message.view = model.view != 0 ? "real" : "virtual";
  message.trial_time = model.trial_ticks * kTickSeconds;
  return message;
}

ExerciseProgress exerciseProgress(const ModelState& model, const Exercise& exercise, const ros::Time& stamp) {
  const ExerciseState& state = model.exercise;
  ExerciseProgress message;
  message.header.stamp = stamp;
  message.exercise = exercise.name;
  message.title = exercise.title;
  message.status = nameOf(kExerciseStatusNames, state.status);
  message.failure = nameOf(kExerciseFailureNames, state.failure);
  message.attempt = state.attempt;
  message.step = state.step;
  for (std::size_t i = 0; i < exercise.tracks.size() && i < kMaxTracks; ++i) {
    message.steps += static_cast<std::uint32_t>(exercise.tracks[i].steps.size());
    message.tracks.push_back(exercise.tracks[i].name);
    message.done.push_back(state.done[i]);
    message.current.push_back(currentStep(state, exercise, i));
  }
  message.mistakes.assign(kMistakeNames.begin(), kMistakeNames.end());
  message.mistake_counts.assign(state.mistakes.begin(), state.mistakes.end());
  message.elapsed = elapsed(state, model.tick);
  message.time_limit = exercise.time_limit;
  message.progress = state.progress;
  return message;
}

ExerciseEventStamped exerciseEvent(std::uint64_t number,
                                   const ExerciseRecord& record,
                                   const Exercise& exercise,
                                   const std::vector<std::string>& body_names,
                                   const ros::Time& stamp) {
  const ExerciseEvent& event = record.event;
  ExerciseEventStamped message;
  message.header.stamp = stamp;
  message.number = number;
  message.tick = record.tick;
  message.event = nameOf(kExerciseEventNames, event.kind);
  if (hasMistake(event.kind)) message.mistake = nameOf(kMistakeNames, event.mistake);
  if (hasArm(event.kind)) message.arm = nameOf(kHandNames, event.arm);
  nameStep(event, exercise, &message);
  message.a = bodyName(body_names, event.a);
  message.b = bodyName(body_names, event.b);
  message.value = event.value;
  message.force = event.force;
  return message;
}

bool isSameMode(const ModelState& a, const ModelState& b) noexcept {
  const auto fields = [](const ModelState& m) { return std::tie(m.mode, m.pedal, m.engaged, m.linked, m.view); };
  return fields(a) == fields(b);
}

bool isSameProgress(const ExerciseState& a, const ExerciseState& b) noexcept {
  const auto fields = [](const ExerciseState& s) {
    return std::tie(s.status, s.failure, s.attempt, s.step, s.done, s.began, s.ended, s.mistakes);
  };
  return fields(a) == fields(b);
}

}  // namespace raven2_trainer::ros_bridge
