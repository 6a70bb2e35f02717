#pragma once

#include <functional>
#include <vector>

#include "planning/joint_space.h"

namespace raven2_trainer::planning {

/** What FMT* asks of the robot; nothing here knows arms or shapes. */
struct FmtProblem {
  UnitState start{}, goal{};
  std::function<bool(const UnitState&)> is_valid;                  ///< free of collision
  std::function<double(const UnitState&, const UnitState&)> cost;  ///< symmetric, >= 0
  std::function<bool()> stop;                                      ///< polled; true gives up
  std::uint32_t samples{};
  double radius_multiplier{};
  double edge_step{};
  std::uint64_t seed{};
};

/**
 * FMT* of OMPL in the unit cube (paper, Algorithm 1). Samples come from core/random.h, so the same problem and seed
 * give the same path. @return the path from start to goal; empty if none was found, an end is not valid, or `stop` said
 * so.
 */
std::vector<UnitState> searchFmt(const FmtProblem& problem);

/** True if the straight edge is free: both ends and points at most `step` apart. */
bool isEdgeFree(const UnitState& a,
                const UnitState& b,
                double step,
                const std::function<bool(const UnitState&)>& is_valid);

}  // namespace raven2_trainer::planning
