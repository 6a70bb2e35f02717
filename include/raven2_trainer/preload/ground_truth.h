#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/preload/change_log.h"
#include "raven2_trainer/preload/settings.h"

namespace raven2_trainer::preload {

/** The two logs and the counters at the end. */
struct Truth {
  const ChangeLog& boards;
  const ChangeLog& network;
  std::uint64_t cycles{};              ///< begun
  std::uint64_t packets{};             ///< from the first with the pedal down on
  std::int64_t monotonic_offset_ns{};  ///< [ns] of the log's clock above CLOCK_MONOTONIC
  std::int64_t ended_ns{};             ///< [ns] on the log's clock: the program ends
};

/** As `injections` of a session's faults.json, one entry each time a row began to act. JSON text. */
std::string describeTruth(const Order& order, const Truth& truth);

}  // namespace raven2_trainer::preload
