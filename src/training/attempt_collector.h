#pragma once

#include <deque>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/training/motion_metrics.h"
#include "raven2_trainer/training/score.h"
#include "raven2_trainer/training/session_score.h"

namespace raven2_trainer::training {

/** [1 ms] Session ticks, without the last. */
struct TickSpan {
  Tick begin{}, end{};
};

/** An attempt while a log is read. */
struct CollectedAttempt {
  AttemptOutcome outcome;
  AttemptHistory history;
  MotionAccumulator motion;
  TransitCollector transits;
};

/**
 * Sorts a session's records into attempts. Ticks in order; events before their tick; haptic and contact records once
 * their tick was given.
 */
class AttemptCollector {
 public:
  /** @param[in] answers to hazards, which no attempt is charged with. */
  AttemptCollector(const ScoreSettings& settings, const session::LogHeader& header, std::vector<TickSpan> answers);
  void add(const TickRecord& record);
  void add(const ExerciseRecord& record);
  void add(const RequestRecord&) {}
  template <typename Record>
  void addLater(Tick tick, const Record& record) {
    for (auto attempt = attempts_.rbegin(); attempt != attempts_.rend(); ++attempt) {
      if (attempt->motion.has(tick)) return attempt->motion.add(record);
    }
  }
  /** Those at the exercise; without one the whole session. */
  std::vector<CollectedAttempt> take();

 private:
  bool counts(const ModelState& model) const;
  bool begins(const ModelState& model) const;
  bool isAnswering(Tick session_tick) const;
  CollectedAttempt* begin(const ModelState& model);
  CollectedAttempt* attemptOf(const ExerciseState& exercise);
  void note(const ExerciseEvent& event, CollectedAttempt* attempt) const;

  MotionSettings settings_;
  std::vector<ExerciseTrack> tracks_;
  session::LogHeader header_;
  std::vector<TickSpan> answers_;
  std::deque<CollectedAttempt> attempts_;  // in order, not more than 256: ExerciseState::attempt counts to there
  std::vector<ExerciseRecord> events_;     // of the tick that comes next
  bool has_exercise_{false};
};

}  // namespace raven2_trainer::training
