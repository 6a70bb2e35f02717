#pragma once

#include <functional>
#include <string>
#include <vector>

#include "planning/fmt_star.h"
#include "planning/planning_problem.h"
#include "raven2_trainer/core/command.h"

namespace raven2_trainer::planning {

/** A problem, and who shall solve it how. */
struct SearchOrder {
  PlanningTask task;
  std::string planner;    ///< one of kPlannerNames
  FmtSettings settings;   ///< of FMTstar; of the others `samples`, `max_refusals`, `radius_multiplier`
  bool stops_on_draws{};  ///< the others end after `samples` draws, as in lockstep, where there is no time limit
  bool until_stopped{};   ///< anytime planners go on until they are stopped
  PathJudge judge;        ///< may be empty
  std::function<void()> on_sample;  ///< called for each sample that FMTstar keeps; may be empty
};

struct SearchOutcome {
  PlanStatus status{PlanStatus::kNoPath};  ///< kTimeLimit for whatever `stop` was meant to say
  std::vector<UnitState> path;             ///< with kSuccess: as it was found, start and goal included
  PlanningCounts counts;
  FmtCounts fmt;  ///< of FMTstar; of the others refusals
};

/**
 * Puts the planner to the problem. A path that the judge refuses loses the edge it failed on, and the search goes on:
 * FMTstar's from its tree, the others' from the start.
 * @throw std::invalid_argument for a name that is not known, and whatever OMPL throws.
 */
SearchOutcome searchPath(const SearchOrder& order);

}  // namespace raven2_trainer::planning
