#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/record.h"

namespace raven2_trainer {

/**
 * The newest events of an exercise, for an occasional reader; the log has all. Events are numbered from 1, so a reader
 * can see which ones it missed.
 */
struct ExerciseNews {
  static constexpr std::size_t kKept = 64;     ///< four ticks' maximum (training::ExerciseJudge::kMaxEvents)
  std::uint64_t count{};                       ///< events so far
  std::array<ExerciseRecord, kKept> newest{};  ///< event n at n % kKept

  void add(const ExerciseRecord& event) noexcept { newest[++count % kKept] = event; }

  /** Number of the oldest available event after number `seen`; count + 1: there is no such event. */
  std::uint64_t firstAfter(std::uint64_t seen) const noexcept {
    const std::uint64_t oldest = count >= kKept ? count - kKept + 1 : 1;
    return seen + 1 > oldest ? seen + 1 : oldest;
  }
};
static_assert(std::is_trivially_copyable<ExerciseNews>::value, "crosses threads word by word");

}  // namespace raven2_trainer
