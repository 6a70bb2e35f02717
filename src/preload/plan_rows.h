#pragma once

#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::preload {

constexpr std::uint8_t kPedalDown = 3;  ///< run level

/** The rows of one of the two threads: each has its own engine. */
inline FaultPlan rowsOf(const FaultPlan& plan, bool of_network) noexcept {
  FaultPlan rows = plan;
  rows.count = 0;
  for (std::size_t i = 0; i < plan.count && i < kMaxFaults; ++i) {
    if ((plan.faults[i].site == FaultSite::kNetworkLayer) == of_network) rows.faults[rows.count++] = plan.faults[i];
  }
  return rows;
}

}  // namespace raven2_trainer::preload
