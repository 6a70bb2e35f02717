#include "planning/fmt_search.h"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/fmt/FMT.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

namespace ob = ompl::base;
using Space = ob::RealVectorStateSpace;

/** FMT draws until it has n valid samples, however rare they are; past this many tries a sample it gives up. */
constexpr std::uint64_t kTriesPerSample = 200;

UnitState fromOmpl(const ob::State* state) {
  UnitState unit{};
  std::copy_n(state->as<Space::StateType>()->values, kPlanDimension, unit.begin());
  return unit;
}

void toOmpl(const UnitState& unit, ob::State* state) {
  std::copy(unit.begin(), unit.end(), state->as<Space::StateType>()->values);
}

/** Uniform samples from our own generator: OMPL's is seeded for the whole process, before its first use only. */
class SeededSampler : public ob::StateSampler {
 public:
  SeededSampler(const ob::StateSpace* space, std::uint64_t seed, std::uint64_t* draws)
      : ob::StateSampler(space), random_(seed), draws_(draws) {}

  void sampleUniform(ob::State* state) override {
    ++*draws_;
    drawWithin(state, UnitState{}, 1.0);
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    drawWithin(state, fromOmpl(near), distance);
    space_->enforceBounds(state);
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    UnitState unit = fromOmpl(mean);
    for (double& x : unit)
      x += deviation * random_.normal();
    toOmpl(unit, state);
    space_->enforceBounds(state);
  }

 private:
  void drawWithin(ob::State* state, UnitState unit, double distance) {
    const bool whole = distance >= 1.0;
    for (double& x : unit)
      x = whole ? random_.uniform(0.0, 1.0) : random_.uniform(x - distance, x + distance);
    toOmpl(unit, state);
  }

  Random random_;
  std::uint64_t* draws_;
};

/** Eq. (1): additive, because the arm rests at every waypoint. */
class EdgeObjective : public ob::OptimizationObjective {
 public:
  EdgeObjective(const ob::SpaceInformationPtr& si, const FmtProblem& problem)
      : ob::OptimizationObjective(si), problem_(problem) {}

  ob::Cost stateCost(const ob::State* /*state*/) const override { return ob::Cost(0.0); }
  ob::Cost motionCost(const ob::State* a, const ob::State* b) const override {
    return ob::Cost(problem_.cost(fromOmpl(a), fromOmpl(b)));
  }

 private:
  const FmtProblem& problem_;
};

/** Thrown out of OMPL's search when it is told to stop: between two of its polls it may look for neighbours of
 *  hundreds of samples, which is seconds for large n. Nothing of it escapes searchFmt(). */
struct Stopped {};

class EdgeValidator : public ob::MotionValidator {
 public:
  EdgeValidator(const ob::SpaceInformationPtr& si, const FmtProblem& problem)
      : ob::MotionValidator(si), problem_(problem) {}

  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    if (problem_.stop()) return false;  // one expansion may try hundreds of edges
    return isEdgeFree(fromOmpl(a), fromOmpl(b), problem_.edge_step, problem_.is_valid);
  }
  /** The last valid state is the start or the end of the edge: nobody here asks for more. */
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last_valid) const override {
    const bool free = checkMotion(a, b);
    last_valid.second = free ? 1.0 : 0.0;
    if (last_valid.first != nullptr) si_->copyState(last_valid.first, free ? b : a);
    return free;
  }

 private:
  const FmtProblem& problem_;
};

/**
 * OMPL 1.5.2 takes the cost as the distance of its nearest-neighbour search and compares it with a radius in the
 * units of the space: wrong neighbours, and costs by the million (performance.md 2.2). Here the distance is the
 * space's. Neighbours by brute force: cheaper than the default GNAT at these sizes, and GNAT draws random pivots.
 */
class TrueDistanceFmt : public ompl::geometric::FMT {
 public:
  TrueDistanceFmt(const ob::SpaceInformationPtr& si, const FmtProblem& problem)
      : ompl::geometric::FMT(si), problem_(problem) {
    nn_ = std::make_shared<ompl::NearestNeighborsLinear<Motion*>>();
  }

  void setup() override {
    ompl::geometric::FMT::setup();
    nn_->setDistanceFunction([this](const Motion* a, const Motion* b) {
      if (++distances_ % kDistancesPerPoll == 0 && problem_.stop()) throw Stopped{};
      return si_->distance(a->getState(), b->getState());
    });
  }

 private:
  static constexpr std::uint64_t kDistancesPerPoll = 4096;  // some 0.1 ms

  const FmtProblem& problem_;
  std::uint64_t distances_{0};
};

std::shared_ptr<ob::SpaceInformation> makeSpaceInformation(const FmtProblem& problem, std::uint64_t* draws) {
  auto space = std::make_shared<Space>(kPlanDimension);
  space->setBounds(0.0, 1.0);
  space->setStateSamplerAllocator(
      [&problem, draws](const ob::StateSpace* s) { return std::make_shared<SeededSampler>(s, problem.seed, draws); });
  auto si = std::make_shared<ob::SpaceInformation>(space);
  si->setStateValidityChecker([&problem](const ob::State* state) { return problem.is_valid(fromOmpl(state)); });
  si->setMotionValidator(std::make_shared<EdgeValidator>(si, problem));
  si->setup();
  return si;
}

std::shared_ptr<ob::ProblemDefinition> makeDefinition(const ob::SpaceInformationPtr& si, const FmtProblem& problem) {
  auto definition = std::make_shared<ob::ProblemDefinition>(si);
  ob::ScopedState<Space> start(si), goal(si);
  toOmpl(problem.start, start.get());
  toOmpl(problem.goal, goal.get());
  definition->setStartAndGoalStates(start, goal);
  definition->setOptimizationObjective(std::make_shared<EdgeObjective>(si, problem));
  return definition;
}

std::vector<UnitState> readPath(const ob::ProblemDefinition& definition) {
  std::vector<UnitState> path;
  const auto* solution = definition.getSolutionPath()->as<ompl::geometric::PathGeometric>();
  for (std::size_t i = 0; i < solution->getStateCount(); ++i)
    path.push_back(fromOmpl(solution->getState(static_cast<unsigned>(i))));
  return path;
}

}  // namespace

bool isEdgeFree(const UnitState& a,
                const UnitState& b,
                double step,
                const std::function<bool(const UnitState&)>& is_valid) {
  const int count = std::max(1, static_cast<int>(std::ceil(distance(a, b) / step)));
  // Coarse to fine, every point once: an edge in collision is found out early.
  int stride = 1;
  while (stride < count)
    stride *= 2;
  if (!is_valid(a) || !is_valid(b)) return false;
  for (int last = stride; stride > 0; last = stride, stride /= 2) {
    for (int i = stride; i < count; i += stride) {
      const bool seen = last > stride && i % last == 0;
      if (!seen && !is_valid(interpolate(a, b, static_cast<double>(i) / count))) return false;
    }
  }
  return true;
}

std::vector<UnitState> searchFmt(const FmtProblem& problem) {
  if (!problem.is_valid(problem.start) || !problem.is_valid(problem.goal)) return {};  // kills OMPL 1.5.2
  ompl::msg::noOutputHandler();
  std::uint64_t draws = 0;
  const std::uint64_t most_draws = kTriesPerSample * problem.samples;
  const auto si = makeSpaceInformation(problem, &draws);
  const auto definition = makeDefinition(si, problem);
  TrueDistanceFmt planner(si, problem);
  planner.setNumSamples(problem.samples);
  planner.setNearestK(false);
  planner.setRadiusMultiplier(problem.radius_multiplier);
  planner.setExtendedFMT(false);
  planner.setProblemDefinition(definition);
  planner.setup();
  const ob::PlannerTerminationCondition stop([&] { return problem.stop() || draws > most_draws; });
  try {
    const ob::PlannerStatus status = planner.solve(stop);
    return status == ob::PlannerStatus::EXACT_SOLUTION ? readPath(*definition) : std::vector<UnitState>{};
  } catch (const Stopped&) {
    return {};
  }
}

}  // namespace raven2_trainer::planning
