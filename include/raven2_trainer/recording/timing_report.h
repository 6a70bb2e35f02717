#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "raven2_trainer/core/record.h"

// Judgement of a machine by the timing of a loop, in numbers and in words.

namespace raven2_trainer::recording {

/** A loop compared with bare threads on the same machine a moment before. */
struct TimingVerdict {
  double on_time{};          ///< [0, 1] share of ticks that ended within 1 ms of their release
  double calibrated_miss{};  ///< [0, 1] share of the bare thread's ticks that did not
  double allowed_miss{};     ///< [0, 1] 3 calibrated_miss + 0.001
  bool pass{};               ///< ticks there were, no more missed than allowed, and no time was given up
  const char* words{};       ///< as libfranka's communication test: good; warn below 0.95; bad below 0.90
};

TimingVerdict judgeTiming(const LoopTiming& loop, const LoopTiming& calibration) noexcept;

/** Lines of text, one an octave of time: from, count, bar with logarithmic length. */
std::string histogramText(const Histogram& histogram);

/** One loop compared with its calibration, as text. */
std::string timingText(const std::string& name, const LoopTiming& loop, const LoopTiming& calibration);

/** The same for programs; times in microseconds. */
nlohmann::ordered_json timingJson(const LoopTiming& loop, const LoopTiming& calibration);

}  // namespace raven2_trainer::recording
