#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "planning/motion_cost.h"

namespace raven2_trainer::planning {

struct ImprovementTask {
  const MotionCost* cost{};
  std::function<bool(const UnitState&, const UnitState&)> is_edge_free;
  std::function<bool()> stop;  ///< polled; true ends the improvement, what was gained so far stays
  std::uint32_t attempts{};
  std::uint64_t seed{};
};

/**
 * A path that costs no more, by leaving waypoints out and by moving them: toward the line that joins their neighbours,
 * and at random by steps that grow where they help and shrink where they do not. Ends stay, and every edge that is
 * changed is checked. The same path and seed give the same answer.
 */
std::vector<UnitState> improvePath(std::vector<UnitState> path, const ImprovementTask& task);

}  // namespace raven2_trainer::planning
