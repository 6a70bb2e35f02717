#pragma once

#include <cstdint>

#include "raven2_trainer/core/counters.h"

namespace raven2_trainer {

/** A stream of packets of which most are refused. */
struct StreamFinding {
  std::uint32_t number{};    ///< counts them; 0: none yet
  std::uint32_t received{};  ///< in the second in which it was found
  std::uint32_t refused{};   ///< of them
  Reject reason{};           ///< why most of those were
  std::uint8_t lasts{};      ///< 1 it is so still
};

}  // namespace raven2_trainer
