#include "raven2_trainer/training/exercise_tally.h"

#include <algorithm>

namespace raven2_trainer::training {

namespace {

/** Session tick of a model tick, as seen from a later one. There must be no pause between them. */
Tick sessionTick(const ModelState& now, Tick tick) {
  if (tick < 0 || now.session_tick < 0) return -1;
  // Unsigned, because a log's numbers may be any.
  const auto begin = static_cast<std::uint64_t>(now.tick) - static_cast<std::uint64_t>(now.session_tick);
  return std::max<Tick>(-1, static_cast<Tick>(static_cast<std::uint64_t>(tick) - begin));
}

}  // namespace

void ExerciseTally::add(const ModelState& model) {
  const ExerciseState& exercise = model.exercise;
  if (exercise.status != ExerciseStatus::kNone && exercise.attempt != number_) {
    number_ = exercise.attempt;
    if (attempts_.size() < kMaxAttempts) {
      attempts_.emplace_back();
    } else {
      ++beyond_;
    }
  }
  const bool is_listed = !attempts_.empty() && beyond_ == 0;
  ExerciseAttempt* attempt = is_listed ? &attempts_.back() : nullptr;
  for (; !waiting_.empty() && waiting_.front().tick <= model.tick; waiting_.pop_front()) {
    const auto kind = static_cast<std::size_t>(waiting_.front().event.kind);
    if (attempt != nullptr && kind < attempt->events.size()) ++attempt->events[kind];
  }
  if (attempt == nullptr) return;
  if (exercise.began != attempt->state.began) attempt->began = sessionTick(model, exercise.began);
  if (exercise.ended != attempt->state.ended) attempt->ended = sessionTick(model, exercise.ended);
  attempt->state = exercise;
  if (exercise.status == ExerciseStatus::kRunning && traitsOf(model.mode).timed) ++attempt->ticks;
}

}  // namespace raven2_trainer::training
