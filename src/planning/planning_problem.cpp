#include "planning/planning_problem.h"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/goals/GoalState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/planning/path_planner.h"

namespace raven2_trainer::planning {
namespace {

namespace ob = ompl::base;
using Space = ob::RealVectorStateSpace;

/** Uniform samples from our own generator: OMPL's is seeded for the whole process, before its first use only. */
class SeededSampler : public ob::StateSampler {
 public:
  SeededSampler(const ob::StateSpace* space,
                std::uint64_t seed,
                std::uint64_t stream,
                std::atomic<std::uint64_t>* draws)
      : ob::StateSampler(space), random_(seed, stream), draws_(draws) {}

  void sampleUniform(ob::State* state) override {
    countDraw();
    UnitState unit;
    for (double& x : unit)
      x = random_.uniform(0.0, 1.0);
    toOmpl(unit, state);
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    countDraw();
    UnitState unit = fromOmpl(near);
    for (double& x : unit)
      x = random_.uniform(x - distance, x + distance);
    toOmpl(unit, state);
    space_->enforceBounds(state);
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    countDraw();
    UnitState unit = fromOmpl(mean);
    for (double& x : unit)
      x += deviation * random_.normal();
    toOmpl(unit, state);
    space_->enforceBounds(state);
  }

 private:
  void countDraw() { draws_->fetch_add(1, std::memory_order_relaxed); }

  Random random_;
  std::atomic<std::uint64_t>* draws_;
};

/** The space of one problem. Planners take several samplers: each has its own stream. */
std::shared_ptr<Space> makeSpace(std::uint64_t seed, std::atomic<std::uint64_t>* draws) {
  auto space = std::make_shared<Space>(kPlanDimension);
  space->setBounds(0.0, 1.0);
  auto taken = std::make_shared<std::uint64_t>(0);
  space->setStateSamplerAllocator([seed, draws, taken](const ob::StateSpace* s) {
    return std::make_shared<SeededSampler>(s, seed, ++*taken, draws);
  });
  return space;
}

ob::ProblemDefinitionPtr makeDefinition(const ob::SpaceInformationPtr& si,
                                        const PlanningTask& task,
                                        const std::shared_ptr<MotionObjective>& objective) {
  auto definition = std::make_shared<ob::ProblemDefinition>(si);
  ob::ScopedState<Space> start(si), goal(si);
  toOmpl(task.start, start.get());
  toOmpl(task.goal, goal.get());
  definition->setStartAndGoalStates(start, goal);
  // Cost to go by the same bound, which informed planners prune by.
  objective->setCostToGoHeuristic([o = objective.get()](const ob::State* state, const ob::Goal* g) {
    return o->motionCostHeuristic(state, g->as<ob::GoalState>()->getState());
  });
  definition->setOptimizationObjective(objective);
  return definition;
}

}  // namespace

UnitState fromOmpl(const ob::State* state) {
  UnitState unit{};
  std::copy_n(state->as<Space::StateType>()->values, kPlanDimension, unit.begin());
  return unit;
}

void toOmpl(const UnitState& unit, ob::State* state) {
  std::copy(unit.begin(), unit.end(), state->as<Space::StateType>()->values);
}

MotionObjective::MotionObjective(const ob::SpaceInformationPtr& si,
                                 const PlanningTask& task,
                                 PlanningCounts* counts,
                                 std::mutex* serial)
    : ob::OptimizationObjective(si), task_(task), counts_(counts), serial_(serial) {}

ob::Cost MotionObjective::stateCost(const ob::State* /*state*/) const {
  return ob::Cost(0.0);
}

ob::Cost MotionObjective::motionCost(const ob::State* a, const ob::State* b) const {
  constexpr std::uint64_t kCostsPerPoll = 256;  // some 0.1 ms, and 10 ms with the clearance term
  const std::lock_guard<std::mutex> alone(*serial_);
  if (++counts_->cost_evaluations % kCostsPerPoll == 0 && throws_ && task_.stop()) throw Stopped{};
  const UnitState from = fromOmpl(a), to = fromOmpl(b);
  if (task_.cost->countsClearance()) ++counts_->clearance_integrals;
  return ob::Cost(task_.cost->plain(from, to) + task_.cost->clearanceTerm(from, to));
}

ob::Cost MotionObjective::motionCostHeuristic(const ob::State* a, const ob::State* b) const {
  return ob::Cost(task_.cost->lengthWeight() * distance(fromOmpl(a), fromOmpl(b)));
}

/** Straight edges by the task, but those that were blocked. */
class PlanningProblem::EdgeValidator : public ob::MotionValidator {
 public:
  EdgeValidator(const ob::SpaceInformationPtr& si, const PlanningTask& task, PlanningCounts* counts, std::mutex* serial)
      : ob::MotionValidator(si), task_(task), counts_(counts), serial_(serial) {}

  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    const std::lock_guard<std::mutex> alone(*serial_);
    if (task_.stop()) return false;  // one expansion may try hundreds of edges
    ++counts_->edge_checks;
    const UnitState from = fromOmpl(a), to = fromOmpl(b);
    return !isBlocked(from, to) && task_.is_edge_free(from, to);
  }
  /** The last valid state is the start or the end of the edge: nobody here asks for more. */
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last_valid) const override {
    const bool free = checkMotion(a, b);
    last_valid.second = free ? 1.0 : 0.0;
    if (last_valid.first != nullptr) si_->copyState(last_valid.first, free ? b : a);
    return free;
  }

  void block(const UnitState& a, const UnitState& b) { blocked_.emplace_back(a, b); }

 private:
  bool isBlocked(const UnitState& a, const UnitState& b) const {
    return std::any_of(blocked_.begin(), blocked_.end(), [&](const auto& edge) {
      return (edge.first == a && edge.second == b) || (edge.first == b && edge.second == a);
    });
  }

  const PlanningTask& task_;
  PlanningCounts* counts_;
  std::mutex* serial_;
  std::vector<std::pair<UnitState, UnitState>> blocked_;
};

void initialiseOmpl() {
  ompl::msg::noOutputHandler();
  const ob::SpaceInformation space(std::make_shared<ob::RealVectorStateSpace>(1));  // the list of all spaces
  ompl::RNG().uniform01();                                                          // the generator of seeds
}

PlanningProblem::PlanningProblem(const PlanningTask& task) {
  ompl::msg::noOutputHandler();
  space_ = std::make_shared<ob::SpaceInformation>(makeSpace(task.seed, &draws_));
  space_->setStateValidityChecker([this, &task](const ob::State* state) {
    const std::lock_guard<std::mutex> alone(serial_);
    ++counts_.state_checks;
    return task.is_free(fromOmpl(state));
  });
  validator_ = std::make_shared<EdgeValidator>(space_, task, &counts_, &serial_);
  space_->setMotionValidator(validator_);
  space_->setup();
  objective_ = std::make_shared<MotionObjective>(space_, task, &counts_, &serial_);
  definition_ = makeDefinition(space_, task, objective_);
}

PlanningProblem::~PlanningProblem() = default;

PlanningCounts PlanningProblem::counts() const {
  PlanningCounts counts = counts_;
  counts.draws = draws();
  return counts;
}

void PlanningProblem::block(const UnitState& a, const UnitState& b) {
  validator_->block(a, b);
}

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

std::vector<UnitState> readPath(const ob::ProblemDefinition& definition) {
  std::vector<UnitState> path;
  if (!definition.hasExactSolution()) return path;
  const auto* solution = definition.getSolutionPath()->as<ompl::geometric::PathGeometric>();
  for (std::size_t i = 0; i < solution->getStateCount(); ++i)
    path.push_back(fromOmpl(solution->getState(static_cast<unsigned>(i))));
  return path;
}

}  // namespace raven2_trainer::planning
