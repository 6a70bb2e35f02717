#include "planning/path_search.h"

#include <algorithm>

#include "planning/make_planner.h"

namespace raven2_trainer::planning {
namespace {

namespace ob = ompl::base;

PlanStatus statusOf(FmtEnd end) {
  switch (end) {
    case FmtEnd::kSolved:
      return PlanStatus::kSuccess;
    case FmtEnd::kInvalidStart:
      return PlanStatus::kStartInCollision;
    case FmtEnd::kInvalidGoal:
      return PlanStatus::kGoalInCollision;
    case FmtEnd::kAllRefused:
      return PlanStatus::kDynamicsInfeasible;
    case FmtEnd::kStopped:
      return PlanStatus::kTimeLimit;
    default:
      return PlanStatus::kNoPath;
  }
}

SearchOutcome searchByFmtStar(const SearchOrder& order) {
  PlanningProblem problem(order.task);
  FmtStar planner(problem.space(), order.settings, order.judge, order.on_sample);
  planner.setProblemDefinition(problem.definition());
  planner.setup();
  planner.solve(ob::PlannerTerminationCondition(order.task.stop));
  SearchOutcome outcome;
  outcome.status = statusOf(planner.end());
  outcome.path = readPath(*problem.definition());
  outcome.counts = problem.counts();
  outcome.fmt = planner.counts();
  return outcome;
}

/** One of OMPL's planners, begun again after each refusal. */
class StockSearch {
 public:
  explicit StockSearch(const SearchOrder& order) : order_(order), problem_(order.task) {
    // OMPL's FMT ends only at the cost function's word when its search for neighbours is under way.
    if (order.planner == "FMT") problem_.throwWhenStopped();
  }

  SearchOutcome run() {
    PlanningTask const& task = order_.task;
    if (!task.is_free(task.start)) return {PlanStatus::kStartInCollision, {}, {}, {}};
    if (!task.is_free(task.goal)) return {PlanStatus::kGoalInCollision, {}, {}, {}};  // kills FMT of OMPL 1.5.2
    SearchOutcome outcome;
    while (!tryOnce(&outcome)) {
    }
    outcome.counts = problem_.counts();
    return outcome;
  }

 private:
  /** Asked by PRM* from two threads. */
  bool isOver() const {
    const bool drawn = order_.stops_on_draws && problem_.draws() >= drawsAllowed();
    return drawn || order_.task.stop();
  }

  /** FMT counts its samples itself, and more are drawn than are free. */
  std::uint64_t drawsAllowed() const {
    return (order_.planner == "FMT" ? 200U : 1U) * std::uint64_t{order_.settings.samples} * (1 + refusals_);
  }

  /** @return true if there is an answer. */
  bool tryOnce(SearchOutcome* outcome) {
    problem_.definition()->clearSolutionPaths();
    solve();
    outcome->path = readPath(*problem_.definition());
    if (outcome->path.empty()) {
      outcome->status = order_.task.stop() ? PlanStatus::kTimeLimit : withoutPath();
      return true;
    }
    outcome->status = PlanStatus::kSuccess;
    const PathVerdict verdict = order_.judge ? order_.judge(outcome->path) : PathVerdict{};
    if (verdict.accepted) return true;
    outcome->fmt.refusals = ++refusals_;
    const std::size_t edge = std::min(verdict.failed_edge, outcome->path.size() - 2);
    problem_.block(outcome->path[edge], outcome->path[edge + 1]);
    outcome->path.clear();
    outcome->status = order_.task.stop() ? PlanStatus::kTimeLimit : PlanStatus::kDynamicsInfeasible;
    return refusals_ >= order_.settings.max_refusals || order_.task.stop();
  }

  PlanStatus withoutPath() const { return refusals_ > 0 ? PlanStatus::kDynamicsInfeasible : PlanStatus::kNoPath; }

  void solve() {
    const auto planner = makeStockPlanner(order_.planner, problem_,
                                          {order_.settings.samples, order_.settings.radius_multiplier,
                                           order_.until_stopped, order_.task.seed + refusals_});
    try {
      planner->solve(ob::PlannerTerminationCondition([this] { return isOver(); }));
    } catch (const Stopped&) {
      problem_.definition()->clearSolutionPaths();
    }
  }

  const SearchOrder& order_;
  PlanningProblem problem_;
  std::uint32_t refusals_{0};
};

}  // namespace

SearchOutcome searchPath(const SearchOrder& order) {
  return order.planner == "FMTstar" ? searchByFmtStar(order) : StockSearch(order).run();
}

}  // namespace raven2_trainer::planning
