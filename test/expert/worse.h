#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "expert/told.h"

// Clumsy hands against the expert, in the way that the exercise's file expects.

namespace raven2_trainer::testing {

inline bool isDone(const Attempt& attempt) {
  return attempt.exercise().status == ExerciseStatus::kDone;
}

/** 1 to `many`, or the one that is asked for by RAVEN2_TRAINER_SEED. */
inline std::vector<std::uint64_t> seeds(int many) {
  if (const char* one = std::getenv("RAVEN2_TRAINER_SEED")) return {static_cast<std::uint64_t>(std::atoi(one))};
  std::vector<std::uint64_t> all;
  for (int seed = 1; seed <= many; ++seed)
    all.push_back(static_cast<std::uint64_t>(seed));
  return all;
}

/** How many were done, and how long it took. */
inline void tellRate(const char* exercise, std::vector<double> times, std::size_t tried) {
  std::sort(times.begin(), times.end());
  std::printf("  %s: %zu of %zu done, median %.1f s\n", exercise, times.size(), tried,
              times.empty() ? 0.0 : times[times.size() / 2]);
}

/** What the exercise's file expects of a clumsy hand: a kind of thing and which. */
inline std::pair<std::string, std::string> expectation(const ClumsyHand& hand) {
  for (const ScriptValue& value : hand.values) {
    if (value.key.compare(0, 7, "expect/") == 0) return {value.key.substr(7), value.text};
  }
  return {};
}

/** Exercises of most of a minute: the short form does them once, and ends clumsy attempts at the mistake. */
inline bool isLong(const std::string& exercise) {
  return exercise == "peg_transfer" || exercise == "ring_tower_transfer" || exercise == "ring_along_loops";
}

/** Seed of the clumsy hands: where the expert has only the first one, they take the second. */
inline std::uint64_t clumsySeed(const std::string& exercise) {
  return !isFull() && isLong(exercise) ? 2 : 1;
}

inline int seedsOf(const std::string& exercise) {
  return isFull() ? 20 : isLong(exercise) ? 1 : 2;
}

/** Whether the mistake was made that is expected of a clumsy hand. */
inline bool madeMistake(const Attempt& clumsy, const std::pair<std::string, std::string>& expected) {
  if (expected.second == "wire_touches" || expected.second == "wire_time")
    return clumsy.mistakes(Mistake::kWireTouch) > 0;
  const auto mistake = std::find(kMistakeNames.begin(), kMistakeNames.end(), expected.second);
  return expected.first == "mistake" && mistake != kMistakeNames.end() &&
         clumsy.mistakes(static_cast<Mistake>(mistake - kMistakeNames.begin())) > 0;
}

/** Worse than the expert in the way that is expected, and in this test's own terms of what that means. */
inline bool isWorse(const Attempt& clumsy, const Attempt& expert, const std::pair<std::string, std::string>& expected) {
  const auto& [kind, which] = expected;
  if (kind == "fail") return which == nameOf(clumsy.exercise().failure);
  if (kind == "mistake") return madeMistake(clumsy, expected);
  if (which == "time") {
    const bool is_over = clumsy.exercise().failure == ExerciseFailure::kTimeLimit;
    return is_over || clumsy.seconds() > 1.5 * expert.seconds();
  }
  if (which == "sparc") {  // less is worse, and both are negative
    std::printf("  sparc %.2f, of the expert %.2f\n", clumsy.smoothness(), expert.smoothness());
    return clumsy.smoothness() < 1.25 * expert.smoothness();
  }
  if (which == "tremor") {
    std::printf("  tremor %.1f um, of the expert %.1f um\n", 1e6 * clumsy.tremor(), 1e6 * expert.tremor());
    return clumsy.tremor() > 1.5 * expert.tremor();
  }
  if (which == "wire_touches" || which == "wire_time")
    return clumsy.mistakes(Mistake::kWireTouch) > expert.mistakes(Mistake::kWireTouch);
  return false;
}

}  // namespace raven2_trainer::testing
