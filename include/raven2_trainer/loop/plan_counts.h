#pragma once

#include <cstdint>

namespace raven2_trainer {

/** How far the planner is with the plan under way, or how far it came with the newest. */
struct PlanCounts {
  std::uint32_t samples{};   ///< free samples drawn
  std::uint32_t edges{};     ///< edges checked for collision
  std::uint32_t rollouts{};  ///< paths followed by the dynamics
  double best_cost{};        ///< eq. (1) of the best path so far; 0 none yet
};

}  // namespace raven2_trainer
