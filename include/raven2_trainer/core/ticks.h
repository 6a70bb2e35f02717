#pragma once

#include <cmath>

#include "raven2_trainer/core/types.h"

// Seconds to ticks of 1 ms, and back. Real-time safe.

namespace raven2_trainer {

/** @return the nearest tick. */
inline Tick toTicks(double seconds) noexcept {
  return static_cast<Tick>(std::lround(seconds / kTickSeconds));
}

constexpr double toSeconds(Tick ticks) noexcept {
  return static_cast<double>(ticks) * kTickSeconds;
}

}  // namespace raven2_trainer
