#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "raven2_trainer/core/record.h"

namespace raven2_trainer::training {

/** An attempt at an exercise, as its judge reported it. */
struct ExerciseAttempt {
  ExerciseState state{};      ///< at its end, or that of the log
  Tick began{-1}, ended{-1};  ///< [1 ms] session ticks of its timer; -1 never, or before the first pedal-down
  Tick ticks{};               ///< [1 ms] its timer ran (ModeTraits::timed)
  std::array<std::uint64_t, kExerciseEventKindCount> events{};  ///< by kind
};

constexpr std::size_t kMaxAttempts = 1000;  ///< of a session: 300 KB

/** Lists a session's attempts. Records of one kind in order, events before the tick that they belong to. */
class ExerciseTally {
 public:
  void add(const ExerciseRecord& record) { waiting_.push_back(record); }
  void add(const ModelState& model);

  const std::vector<ExerciseAttempt>& attempts() const noexcept { return attempts_; }
  /** Attempts beyond the longest list. */
  std::uint64_t beyond() const noexcept { return beyond_; }

 private:
  std::vector<ExerciseAttempt> attempts_;
  std::deque<ExerciseRecord> waiting_;
  std::uint64_t beyond_{0};
  std::int32_t number_{-1};  ///< of the newest attempt, in the list or not
};

}  // namespace raven2_trainer::training
