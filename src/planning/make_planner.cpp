#include "planning/make_planner.h"

#include <ompl/geometric/planners/fmt/FMT.h>
#include <ompl/geometric/planners/informedtrees/ABITstar.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/prm/PRMstar.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/RandomNumbers.h>

#include <limits>
#include <mutex>
#include <stdexcept>

namespace raven2_trainer::planning {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

/** As OMPL ships it, but ending where its samples do: it would draw on until the time is up. */
ob::PlannerPtr makeFmt(const ob::SpaceInformationPtr& si, const StockSettings& settings) {
  auto fmt = std::make_shared<og::FMT>(si);
  fmt->setNumSamples(settings.samples);
  fmt->setRadiusMultiplier(settings.radius_multiplier);
  fmt->setExtendedFMT(false);
  return fmt;
}

/**
 * BIT* of OMPL 1.5.2 prunes ahead of each batch of samples; with an objective whose informed set has no known measure
 * it goes on pruning (seen: 15 s without a second batch), so pruning is switched off. Edges that cannot improve the
 * path are still skipped in its queue.
 */
template <typename Planner>
ob::PlannerPtr makeBit(const ob::SpaceInformationPtr& si) {
  auto bit = std::make_shared<Planner>(si);
  bit->setPruning(false);
  return bit;
}

ob::PlannerPtr make(const std::string& name, const ob::SpaceInformationPtr& si, const StockSettings& settings) {
  if (name == "FMT") return makeFmt(si, settings);
  if (name == "RRTstar") return std::make_shared<og::RRTstar>(si);
  if (name == "PRMstar") return std::make_shared<og::PRMstar>(si);
  if (name == "BITstar") return makeBit<og::BITstar>(si);
  if (name == "ABITstar") return makeBit<og::ABITstar>(si);
  if (name == "RRTConnect") return std::make_shared<og::RRTConnect>(si);
  throw std::invalid_argument("no planner is called \"" + name + "\"");
}

}  // namespace

ob::PlannerPtr makeStockPlanner(const std::string& name,
                                const PlanningProblem& problem,
                                const StockSettings& settings) {
  static std::mutex seeding;
  const std::lock_guard<std::mutex> alone(seeding);
  ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(1 + settings.seed % 0xFFFFFFFEU));  // 0 means: by the clock
  const ob::PlannerPtr planner = make(name, problem.space(), settings);
  // Any path satisfies who does not ask for more; none does who asks for all the time there is.
  const double enough = settings.until_stopped ? 0.0 : std::numeric_limits<double>::infinity();
  problem.definition()->getOptimizationObjective()->setCostThreshold(ob::Cost(enough));
  planner->setProblemDefinition(problem.definition());
  planner->setup();
  return planner;
}

}  // namespace raven2_trainer::planning
