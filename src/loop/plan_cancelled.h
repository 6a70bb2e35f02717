#pragma once

#include <atomic>

#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** The flag that gives up the plan with this serial number. */
inline std::atomic<bool>& planCancelled(SharedState* shared, std::uint32_t serial) noexcept {
  return shared->plan_cancelled[serial % kMaxPlansUnderWay];
}

}  // namespace raven2_trainer::loop
