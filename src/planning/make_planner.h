#pragma once

#include <ompl/base/Planner.h>

#include <string>

#include "planning/planning_problem.h"

namespace raven2_trainer::planning {

/** Settings of OMPL's planners. */
struct StockSettings {
  std::uint32_t samples{};     ///< of FMT
  double radius_multiplier{};  ///< of FMT
  bool until_stopped{};        ///< anytime planners go on after their first path
  std::uint64_t seed{};
};

/**
 * One of OMPL's own planners on the problem, set up: FMT, RRTstar, PRMstar, BITstar, ABITstar, RRTConnect. Its
 * generators are seeded; as they draw their seeds from one generator of the process, the same seed gives the same path
 * only where no other thread makes planners meanwhile. PRMstar looks for its path in its own thread: its paths
 * differ from run to run.
 * @throw std::invalid_argument for another name.
 */
ompl::base::PlannerPtr makeStockPlanner(const std::string& name,
                                        const PlanningProblem& problem,
                                        const StockSettings& settings);

}  // namespace raven2_trainer::planning
