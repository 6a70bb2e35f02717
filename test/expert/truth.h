#pragma once

#include <string>
#include <vector>

#include "expert/attempt.h"

// Checks the judge against the surgeon's own record, which the judge does not read.

namespace raven2_trainer::testing {

/** A step and the verb of the script that does it. */
struct ScriptedStep {
  std::uint8_t track{}, step{};
  int verb{};  ///< number in the script
};

/** Steps of exercises with rings, in the order of the script. The verbs carry, take_over and put_over each do the next
 *  step of their object: lift, hand over, place. */
inline std::vector<ScriptedStep> scriptedSteps(const Exercise& exercise, const std::vector<console::Verb>& verbs) {
  std::vector<ScriptedStep> steps;
  std::vector<std::uint8_t> next(exercise.tracks.size(), 0);
  for (std::size_t i = 0; i < verbs.size(); ++i) {
    const console::VerbKind kind = verbs[i].kind;
    const bool does_step = kind == console::VerbKind::kCarry || kind == console::VerbKind::kTakeOver ||
                           kind == console::VerbKind::kPutOver;
    for (std::uint8_t track = 0; does_step && track < exercise.tracks.size(); ++track) {
      if (exercise.tracks[track].object == verbs[i].object)
        steps.push_back({track, next[track]++, static_cast<int>(i)});
    }
  }
  return steps;
}

/** First and last tick of a verb's event; -1 if there is no such event. */
struct Span {
  Tick first{-1}, last{-1};
};

inline Span spanOf(const Attempt& attempt, int verb, const std::string& what) {
  Span span;
  for (const console::TruthEvent& event : attempt.truth().events()) {
    if (event.verb != verb || event.what != what) continue;
    const Tick tick = attempt.tickOf(event.sequence);
    if (span.first < 0) span.first = tick;
    span.last = tick;
  }
  return span;
}

inline int toldOf(const Attempt& attempt, const std::string& what) {
  int count = 0;
  for (const console::TruthEvent& event : attempt.truth().events())
    count += event.what == what ? 1 : 0;
  return count;
}

inline std::vector<ExerciseRecord> eventsOf(const Attempt& attempt, ExerciseEventKind kind) {
  std::vector<ExerciseRecord> found;
  for (const ExerciseRecord& record : attempt.events()) {
    if (record.event.kind == kind) found.push_back(record);
  }
  return found;
}

/**
 * The ticks in which the judge may report a step as done. The first is the begin of its verb, or the tick in which the
 * jaws began to close for it, because closing may lift the object. If the verb opens the jaws, the first is that tick.
 * The last is the verb's end plus the step's dwell plus 200 ticks. These cover the robot's lag of 80 ms, the 50 ticks
 * without a press after which an object counts as released, and the mean of its speed over 20 ticks.
 */
inline Span windowOf(const Attempt& attempt, const ScriptedStep& step) {
  constexpr Tick kOnTop = 200;
  const ExerciseStep& what = attempt.config().exercise.tracks[step.track].steps[step.step];
  const Span begin = spanOf(attempt, step.verb, "begin"), open = spanOf(attempt, step.verb, "open"),
             close = spanOf(attempt, step.verb - 1, "close"), end = spanOf(attempt, step.verb, "end");
  // A verb that the end of the attempt cuts off has no end.
  const bool is_cut_off = end.last < 0 && spanOf(attempt, step.verb + 1, "begin").first < 0;
  const Tick over = is_cut_off ? attempt.model().tick : end.last;
  const Tick taken = close.last >= 0 ? close.last : begin.first;
  return {open.first >= 0 ? open.first : taken, over + std::llround(what.dwell / kTickSeconds) + kOnTop};
}

/** Adds a failure for each step that the judge reported out of the script's order or outside of its window. After a
 *  drop, steps may be late. */
inline void expectStepsAsDone(const Attempt& attempt, const std::vector<ScriptedStep>& steps, const std::string& who) {
  const std::vector<ExerciseRecord> seen = eventsOf(attempt, ExerciseEventKind::kStepDone);
  ASSERT_LE(seen.size(), steps.size()) << who;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(static_cast<int>(seen[i].event.track), static_cast<int>(steps[i].track)) << who << ", step " << i;
    EXPECT_EQ(static_cast<int>(seen[i].event.step), static_cast<int>(steps[i].step)) << who << ", step " << i;
    const Span window = windowOf(attempt, steps[i]);
    EXPECT_GE(seen[i].tick, window.first) << who << ", step " << i << " of verb " << steps[i].verb;
    if (attempt.mistakes(Mistake::kDrop) > 0) continue;
    EXPECT_LE(seen[i].tick, window.last) << who << ", step " << i << " of verb " << steps[i].verb;
  }
}

}  // namespace raven2_trainer::testing
