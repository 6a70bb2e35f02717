#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "expert/told.h"

// Compares clumsy surgeons with the expert, by the expectation in the exercise's file.

namespace raven2_trainer::testing {

inline bool isDone(const Attempt& attempt) {
  return attempt.exercise().status == ExerciseStatus::kDone;
}

/** Seeds 1 to `many`, or only the seed in RAVEN2_TRAINER_SEED. */
inline std::vector<std::uint64_t> seeds(int many) {
  if (const char* one = std::getenv("RAVEN2_TRAINER_SEED")) return {static_cast<std::uint64_t>(std::atoi(one))};
  std::vector<std::uint64_t> all;
  for (int seed = 1; seed <= many; ++seed)
    all.push_back(static_cast<std::uint64_t>(seed));
  return all;
}

/** Prints how many attempts were done, and their median time. */
inline void tellRate(const char* exercise, std::vector<double> times, std::size_t tried) {
  std::sort(times.begin(), times.end());
  std::printf("  %s: %zu of %zu done, median %.1f s\n", exercise, times.size(), tried,
              times.empty() ? 0.0 : times[times.size() / 2]);
}

/** The expectation of a clumsy surgeon in the exercise's file: kind (mistake, metric or fail) and name. */
inline std::pair<std::string, std::string> expectation(const ClumsyHand& hand) {
  for (const ScriptValue& value : hand.values) {
    if (value.key.compare(0, 7, "expect/") == 0) return {value.key.substr(7), value.text};
  }
  return {};
}

/** Exercises of almost a minute. The short form does them once, and ends clumsy attempts at the mistake. */
inline bool isLong(const std::string& exercise) {
  return exercise == "peg_transfer" || exercise == "ring_tower_transfer" || exercise == "ring_along_loops";
}

/** Seed of the clumsy surgeons: the second one, if the expert uses only the first. */
inline std::uint64_t clumsySeed(const std::string& exercise) {
  return !isFull() && isLong(exercise) ? 2 : 1;
}

inline int seedsOf(const std::string& exercise) {
  return isFull() ? 20 : isLong(exercise) ? 1 : 2;
}

/** Whether a clumsy surgeon made the expected mistake. */
inline bool madeMistake(const Attempt& clumsy, const std::pair<std::string, std::string>& expected) {
  if (expected.second == "wire_touches" || expected.second == "wire_time")
    return clumsy.mistakes(Mistake::kWireTouch) > 0;
  const auto mistake = std::find(kMistakeNames.begin(), kMistakeNames.end(), expected.second);
  return expected.first == "mistake" && mistake != kMistakeNames.end() &&
         clumsy.mistakes(static_cast<Mistake>(mistake - kMistakeNames.begin())) > 0;
}

/** Whether a clumsy attempt is worse than the expert's, as the exercise's file expects. The limits are this test's. */
inline bool isWorse(const Attempt& clumsy, const Attempt& expert, const std::pair<std::string, std::string>& expected) {
  const auto& [kind, which] = expected;
  if (kind == "fail") return which == nameOf(clumsy.exercise().failure);
  if (kind == "mistake") return madeMistake(clumsy, expected);
  if (which == "time") {
    const bool is_over = clumsy.exercise().failure == ExerciseFailure::kTimeLimit;
    return is_over || clumsy.seconds() > 1.5 * expert.seconds();
  }
  if (which == "sparc") {  // a lower value is worse; both are negative
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
