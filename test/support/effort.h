#pragma once

#include <cstdint>
#include <cstdlib>

namespace raven2_trainer::testing {

/** Whether `scripts/test --full` runs: the long form of tests that have a short one. */
inline bool isFull() {
  const char* full = std::getenv("RAVEN2_TRAINER_FULL");
  return full != nullptr && full[0] == '1';
}

/** How often to repeat: the promised number in the long form, a part of it otherwise. */
inline std::int64_t effort(std::int64_t quick, std::int64_t full) {
  return isFull() ? full : quick;
}

}  // namespace raven2_trainer::testing
