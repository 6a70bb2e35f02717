#pragma once

#include <vector>

#include "planning/solid.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/** All fixed things: the scene without its free bodies (the goal of a plan is AT the ring, which is there to be
 *  touched and gives way), then the robot's fixed parts in the order of JudgedPairs::fixed. */
struct StandingSolids {
  std::vector<Solid> solids;  ///< in W
  std::size_t scene_count{};  ///< of these, the scene's
};

/** @throw ModelException for a mesh. */
StandingSolids standingSolids(const model::RavenModel& raven, const model::SceneModel& scene);

}  // namespace raven2_trainer::planning
