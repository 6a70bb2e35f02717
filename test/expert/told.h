#pragma once

#include <cstdio>
#include <string>

#include "expert/attempt.h"
#include "support/effort.h"

// Prints the result of an attempt.

namespace raven2_trainer::testing {

inline const char* nameOf(ExerciseStatus status) {
  return kExerciseStatusNames[static_cast<std::size_t>(status)];
}
inline const char* nameOf(ExerciseFailure failure) {
  return kExerciseFailureNames[static_cast<std::size_t>(failure)];
}

inline std::string mistakesOf(const Attempt& attempt) {
  std::string all;
  for (std::size_t i = 0; i < kMistakeCount; ++i) {
    const std::uint32_t n = attempt.exercise().mistakes[i];
    if (n > 0) all += " " + std::string(kMistakeNames[i]) + " " + std::to_string(n);
  }
  return all.empty() ? " none" : all;
}

/** Prints one line about the attempt. */
inline void tell(const std::string& who, const Attempt& attempt) {
  const ExerciseState& state = attempt.exercise();
  std::printf(
      "  %s: %s (%s) after %.1f s, step %u, %s by poses; mistakes:%s; at most %.1f N on a hand, mode %s, robot "
      "%s, hands %s at %.1f s\n",
      who.c_str(), nameOf(state.status), nameOf(state.failure), attempt.seconds(), state.step,
      attempt.isAllPlaced() ? "placed" : "not placed", mistakesOf(attempt).c_str(), attempt.largestForce(),
      kModeNames[static_cast<std::size_t>(attempt.model().mode)],
      kRunLevelNames[static_cast<std::size_t>(attempt.robot().runlevel)], attempt.finished() ? "finished" : "busy",
      static_cast<double>(attempt.model().tick) * kTickSeconds);
}

/** Prints the surgeon's actions and the judge's events, in order of time. */
inline void tellAll(const Attempt& attempt) {
  std::multimap<Tick, std::string> lines;
  for (const console::TruthEvent& event : attempt.truth().events())
    lines.emplace(attempt.tickOf(event.sequence),
                  "hands " + event.what + " " + std::to_string(event.verb) + " " + event.detail);
  for (const ExerciseRecord& record : attempt.events()) {
    const ExerciseEvent& e = record.event;
    std::string text = std::string("judge ") + kExerciseEventNames[static_cast<std::size_t>(e.kind)];
    if (e.track != kNobody) text += " track " + std::to_string(e.track) + " step " + std::to_string(e.step);
    if (e.a != 0xFFFF) text += " " + attempt.nameOf(e.a);
    if (e.b != 0xFFFF) text += " " + attempt.nameOf(e.b);
    if (e.kind == ExerciseEventKind::kMistake)
      text += std::string(" ") + kMistakeNames[static_cast<std::size_t>(e.mistake)];
    if (e.arm != Hand::kAny) text += std::string(" ") + kHandNames[static_cast<std::size_t>(e.arm)];
    if (e.force > 0.0) text += " " + std::to_string(e.force) + " N";
    lines.emplace(record.tick, text);
  }
  for (const auto& [tick, text] : lines)
    std::printf("    %8.3f %s\n", static_cast<double>(tick) * kTickSeconds, text.c_str());
}

}  // namespace raven2_trainer::testing
