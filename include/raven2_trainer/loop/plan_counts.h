#pragma once

#include <cstdint>

namespace raven2_trainer {

/** Progress of the running or last plan. */
struct PlanCounts {
  std::uint32_t samples{};   ///< free samples drawn
  std::uint32_t edges{};     ///< edges checked for collision
  std::uint32_t rollouts{};  ///< paths simulated with dynamics
  double best_cost{};        ///< eq. (1) of the best path so far; 0: no path yet
};

}  // namespace raven2_trainer
