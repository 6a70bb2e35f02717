#include "planning/fmt_star.h"

#include <gtest/gtest.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>

#include <algorithm>
#include <cmath>

#include "planning/free_volume.h"
#include "planning/path_search.h"
#include "planning_fixtures.h"
#include "raven2_trainer/planning/path_planner.h"

namespace raven2_trainer::planning {
namespace {

namespace ob = ompl::base;

using Path = std::vector<UnitState>;

std::shared_ptr<const MotionCost> cost(const CostWeights& weights, const ClearanceFunction& clearance = {}) {
  const ArmGeometry geometry = test::geometry();
  return std::make_shared<MotionCost>(geometry, Arm::kGold, JointSpace(geometry, 0.5), test::plannerConfig(), weights,
                                      clearance);
}

SearchOrder orderFor(const std::function<bool(const UnitState&)>& is_free) {
  SearchOrder order;
  order.task.start = {0.2, 0.5, 0.5, 0.5, 0.5, 0.5};
  order.task.goal = {0.8, 0.5, 0.5, 0.5, 0.5, 0.5};
  order.task.is_free = is_free;
  order.task.is_edge_free = [is_free](const UnitState& a, const UnitState& b) {
    return isEdgeFree(a, b, 0.002, is_free);
  };
  order.task.cost = cost({1.0, 0.0, 0.0, 1.0});
  order.task.stop = [] { return false; };
  order.task.seed = 1;
  order.planner = "FMTstar";
  order.settings = {500, 500, 20, 1.4, 1.0};
  return order;
}

bool nothingInTheWay(const UnitState& /*x*/) {
  return true;
}

/** A wall across the first axis with a gap where the second exceeds 0.8. */
bool outsideWall(const UnitState& x) {
  return std::abs(x[0] - 0.5) > 0.05 || x[1] > 0.8;
}

double length(const Path& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    sum += distance(path[i - 1], path[i]);
  return sum;
}

bool isOutsideWallThroughout(const Path& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    for (int k = 0; k <= 1000; ++k) {
      const UnitState x = interpolate(path[i - 1], path[i], k / 1000.0);
      // Between two checks, 0.002 apart, a path may cut a corner.
      if (std::abs(x[0] - 0.5) < 0.049 && x[1] < 0.799) return false;
    }
  }
  return true;
}

TEST(FmtStar, ReturnsTheStraightEdgeWhereNothingIsInTheWay) {
  // The goal, 0.6 away, is within the radius: 1.4 x 0.54 at n = 500.
  const SearchOrder order = orderFor(nothingInTheWay);
  const SearchOutcome outcome = searchPath(order);
  ASSERT_EQ(outcome.status, PlanStatus::kSuccess);
  EXPECT_EQ(outcome.path, (Path{order.task.start, order.task.goal}));
}

TEST(FmtStar, FindsTheGapInAWall) {
  SearchOrder order = orderFor(outsideWall);
  for (order.task.seed = 1; order.task.seed <= 10; ++order.task.seed) {
    const SearchOutcome outcome = searchPath(order);
    ASSERT_EQ(outcome.status, PlanStatus::kSuccess) << "seed " << order.task.seed;
    ASSERT_GE(outcome.path.size(), 3u);
    EXPECT_EQ(outcome.path.front(), order.task.start);
    EXPECT_EQ(outcome.path.back(), order.task.goal);
    // The shortest path passes the two corners of the gap: sqrt(0.25^2 + 0.3^2) twice and the wall's thickness.
    EXPECT_GE(length(outcome.path), 2 * std::hypot(0.25, 0.3) + 0.1);
    EXPECT_TRUE(isOutsideWallThroughout(outcome.path)) << "seed " << order.task.seed;
  }
}

TEST(FmtStar, TheCostFallsWithTheSamples) {
  SearchOrder order = orderFor(outsideWall);
  const auto mean = [&](std::uint32_t samples) {
    order.settings.samples = order.settings.max_samples = samples;
    double sum = 0.0;
    for (order.task.seed = 1; order.task.seed <= 10; ++order.task.seed)
      sum += length(searchPath(order).path) / 10;
    return sum;
  };
  const double few = mean(200), many = mean(3000);
  EXPECT_LT(many, few);
}

TEST(FmtStar, NeighboursAreNearInSpaceWhateverTheCost) {
  // GIVEN a cost a thousand times the length: measured by cost, nothing is within the radius
  SearchOrder order = orderFor(outsideWall);
  const Path by_length = searchPath(order).path;
  order.task.cost = cost({1024.0, 0.0, 0.0, 1.0});
  // THEN the same graph is searched and the same path found
  EXPECT_EQ(searchPath(order).path, by_length);
}

TEST(FmtStar, TakesAnyObjectiveOfOmpl) {
  // GIVEN OMPL's own path length instead of ours THEN the path has the same cost as by our own objective
  SearchOrder order = orderFor(outsideWall);
  PlanningProblem problem(order.task);
  problem.definition()->setOptimizationObjective(
      std::make_shared<ob::PathLengthOptimizationObjective>(problem.space()));
  FmtStar planner(problem.space(), order.settings);
  planner.setProblemDefinition(problem.definition());
  planner.setup();
  EXPECT_EQ(planner.solve(ob::plannerNonTerminatingCondition()), ob::PlannerStatus::EXACT_SOLUTION);
  EXPECT_NEAR(length(readPath(*problem.definition())), length(searchPath(order).path), 1e-12);
  // AND the tree can be cleared
  planner.clear();
  EXPECT_EQ(planner.counts().samples, 0u);
}

TEST(PlanningProblemEdges, OneThatIsBlockedIsBlockedBothWaysAndNoOther) {
  SearchOrder order = orderFor(outsideWall);
  order.task.is_edge_free = [](const UnitState&, const UnitState&) { return true; };
  PlanningProblem problem(order.task);
  const std::array<UnitState, 3> units{UnitState{0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, UnitState{0.9, 0.8, 0.7, 0.6, 0.5, 0.4},
                                       UnitState{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}};
  const auto isFree = [&](std::size_t from, std::size_t to) {
    ob::ScopedState<> a(problem.space()), b(problem.space());
    toOmpl(units[from], a.get());
    toOmpl(units[to], b.get());
    return problem.space()->checkMotion(a.get(), b.get());
  };
  EXPECT_TRUE(isFree(0, 1));
  problem.block(units[0], units[1]);
  EXPECT_FALSE(isFree(0, 1));
  EXPECT_FALSE(isFree(1, 0));
  EXPECT_TRUE(isFree(0, 2));
  EXPECT_TRUE(isFree(2, 1));
}

/** FMT* without optimizations: all costs exact, no memory, ordered by cost so far plus length to go. */
Path plainFmt(const SearchOrder& order, const std::vector<UnitState>& points, double radius) {
  const auto exact = [&](std::size_t a, std::size_t b) {
    return order.task.cost->plain(points[a], points[b]) +
           order.task.cost->clearanceTerm(points[std::min(a, b)], points[std::max(a, b)]);
  };
  std::vector<int> place(points.size(), 0), parent(points.size(), -1);  // 0 unvisited, 1 open, 2 closed
  std::vector<double> g(points.size(), 0.0);
  place[0] = 1;
  std::vector<std::pair<std::size_t, std::size_t>> blocked;
  while (place[1] == 0) {
    int z = -1;
    const auto key = [&](std::size_t i) {
      return g[i] + order.task.cost->lengthWeight() * distance(points[i], points[1]);
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (place[i] == 1 && (z < 0 || key(i) < key(static_cast<std::size_t>(z)))) z = static_cast<int>(i);
    }
    if (z < 0) return {};
    std::vector<std::size_t> fresh;
    for (std::size_t x = 0; x < points.size(); ++x) {
      if (place[x] != 0 || distance(points[x], points[static_cast<std::size_t>(z)]) > radius) continue;
      int best = -1;
      double least = 1e300;
      for (std::size_t y = 0; y < points.size(); ++y) {
        const bool known =
            std::count(blocked.begin(), blocked.end(), std::make_pair(std::min(x, y), std::max(x, y))) > 0;
        if (place[y] != 1 || distance(points[x], points[y]) > radius || known) continue;
        if (g[y] + exact(y, x) < least) {
          least = g[y] + exact(y, x);
          best = static_cast<int>(y);
        }
      }
      if (best < 0) continue;
      if (!order.task.is_edge_free(points[static_cast<std::size_t>(best)], points[x])) {
        const auto y = static_cast<std::size_t>(best);
        blocked.emplace_back(std::min(x, y), std::max(x, y));
        continue;
      }
      parent[x] = best;
      g[x] = least;
      fresh.push_back(x);
    }
    place[static_cast<std::size_t>(z)] = 2;
    for (const std::size_t x : fresh)
      place[x] = 1;
  }
  Path path;
  for (int i = 1; i >= 0; i = parent[static_cast<std::size_t>(i)])
    path.insert(path.begin(), points[static_cast<std::size_t>(i)]);
  return path;
}

TEST(FmtStar, FindsWhatThePlainAlgorithmFinds) {
  // GIVEN the same samples, and both terms of eq. (1)
  SearchOrder order = orderFor(outsideWall);
  order.task.cost = cost({0.1, 0.5, 0.0, 1.0});
  order.settings.samples = order.settings.max_samples = 150;
  for (order.task.seed = 1; order.task.seed <= 5; ++order.task.seed) {
    std::vector<UnitState> points;
    order.task.is_free = [&points](const UnitState& x) {
      if (outsideWall(x)) points.push_back(x);
      return outsideWall(x);
    };
    const Path found = searchPath(order).path;
    ASSERT_EQ(points.size(), 152u) << "the points are start, goal and the samples";
    const Path expected = plainFmt(order, points, fmtRadius(1.0, 1.4, 150));
    ASSERT_FALSE(expected.empty());
    // THEN the lazy search gives the same path
    EXPECT_EQ(found, expected) << "seed " << order.task.seed;
  }
}

/** A distance that varies over the whole cube, [0, 40] mm. */
double wavyDistance(const UnitState& x, double cap) {
  return std::min(cap, 0.02 + 0.02 * std::sin(9.0 * x[0] + 7.0 * x[1] - 5.0 * x[2] + 3.0 * x[3]));
}

TEST(FmtStar, FindsWhatThePlainAlgorithmFindsWhereTheClearanceCounts) {
  // GIVEN no obstacle, but a clearance term that makes detours worth while
  SearchOrder order = orderFor(nothingInTheWay);
  order.task.start = {0.1, 0.2, 0.1, 0.2, 0.5, 0.5};
  order.task.goal = {0.9, 0.8, 0.9, 0.8, 0.5, 0.5};  // farther than the radius
  order.task.cost = cost({0.1, 0.5, 5.0, 0.03}, wavyDistance);
  order.settings.samples = order.settings.max_samples = 150;
  for (order.task.seed = 1; order.task.seed <= 10; ++order.task.seed) {
    std::vector<UnitState> points;
    order.task.is_free = [&points](const UnitState& x) {
      points.push_back(x);
      return true;
    };
    const SearchOutcome found = searchPath(order);
    ASSERT_EQ(points.size(), 152u);
    // THEN terms that are integrated only as far as they decide give the same path as the full costs
    EXPECT_EQ(found.path, plainFmt(order, points, fmtRadius(1.0, 1.4, 150))) << "seed " << order.task.seed;
    EXPECT_GT(found.path.size(), 2u);
    EXPECT_GT(found.counts.clearance_integrals, 0u);
  }
}

/** The same cost in one piece, so that no part of it can be left out. */
class WholeCost : public ob::OptimizationObjective {
 public:
  WholeCost(const ob::SpaceInformationPtr& si, ob::OptimizationObjectivePtr of)
      : ob::OptimizationObjective(si), of_(std::move(of)) {}
  ob::Cost stateCost(const ob::State* /*state*/) const override { return ob::Cost(0.0); }
  ob::Cost motionCost(const ob::State* a, const ob::State* b) const override { return of_->motionCost(a, b); }
  ob::Cost motionCostHeuristic(const ob::State* a, const ob::State* b) const override {
    return of_->motionCostHeuristic(a, b);
  }

 private:
  const ob::OptimizationObjectivePtr of_;
};

TEST(FmtStar, WhatWasNotFollowedToItsEndIsTakenUpWhenPathsAreRefused) {
  // GIVEN a judge that refuses forty paths, so that the search needs edges that it had dismissed
  SearchOrder order = orderFor(nothingInTheWay);
  order.task.start = {0.1, 0.2, 0.1, 0.2, 0.5, 0.5};
  order.task.goal = {0.9, 0.8, 0.9, 0.8, 0.5, 0.5};
  order.task.cost = cost({0.1, 0.5, 5.0, 0.03}, wavyDistance);
  order.settings.samples = order.settings.max_samples = 200;
  order.settings.max_refusals = 100;
  const auto search = [&order](bool whole) {
    std::vector<Path> shown;
    PlanningProblem problem(order.task);
    const auto& objective = problem.definition()->getOptimizationObjective();
    if (whole) problem.definition()->setOptimizationObjective(std::make_shared<WholeCost>(problem.space(), objective));
    FmtStar planner(problem.space(), order.settings, [&shown](const Path& path) -> PathVerdict {
      shown.push_back(path);
      return {shown.size() > 40, shown.size() % (path.size() - 1)};
    });
    planner.setProblemDefinition(problem.definition());
    planner.setup();
    planner.solve(ob::plannerNonTerminatingCondition());
    return shown;
  };
  for (order.task.seed = 1; order.task.seed <= 5; ++order.task.seed) {
    const std::vector<Path> whole = search(true);
    EXPECT_EQ(whole.size(), 41u);
    EXPECT_EQ(search(false), whole) << "seed " << order.task.seed;
  }
}

TEST(FmtStar, GivesTheSamePathForTheSameSeedOnly) {
  SearchOrder order = orderFor(outsideWall);
  const Path first = searchPath(order).path;
  EXPECT_EQ(searchPath(order).path, first);
  order.task.seed = 2;
  EXPECT_NE(searchPath(order).path, first);
}

TEST(FmtStar, EndsWithoutAPathBehindAWholeWallHoweverManySamplesItAdds) {
  SearchOrder order = orderFor([](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.05; });
  order.settings.samples = 100;
  order.settings.max_samples = 400;
  const SearchOutcome outcome = searchPath(order);
  EXPECT_EQ(outcome.status, PlanStatus::kNoPath);
  EXPECT_EQ(outcome.fmt.samples, 400u);  // 100, 150, 225, 338, 400
  EXPECT_EQ(outcome.fmt.rounds, 4u);
}

TEST(FmtStar, AddsSamplesToTheSameTreeWhereTooFewWereTaken) {
  // GIVEN a gap that few samples find
  SearchOrder order = orderFor([](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.05 || x[1] > 0.9; });
  order.settings.samples = 20;
  int failed = 0, helped = 0;
  for (order.task.seed = 1; order.task.seed <= 20; ++order.task.seed) {
    order.settings.max_samples = 20;
    if (searchPath(order).status == PlanStatus::kSuccess) continue;
    ++failed;
    order.settings.max_samples = 4000;
    const SearchOutcome outcome = searchPath(order);
    helped += outcome.status == PlanStatus::kSuccess && outcome.fmt.samples > 20 ? 1 : 0;
  }
  EXPECT_GT(failed, 0);
  EXPECT_EQ(helped, failed);
}

TEST(FmtStar, SurvivesAnInvalidGoalOrStart) {
  // OMPL 1.5.2 ends the process on an invalid goal.
  SearchOrder order = orderFor([](const UnitState& x) { return x[0] < 0.7; });
  EXPECT_EQ(searchPath(order).status, PlanStatus::kGoalInCollision);
  order = orderFor([](const UnitState& x) { return x[0] > 0.3; });
  EXPECT_EQ(searchPath(order).status, PlanStatus::kStartInCollision);
  order = orderFor(nothingInTheWay);
  order.task.goal[2] = 1.5;
  EXPECT_EQ(searchPath(order).status, PlanStatus::kGoalInCollision);
  order.task.goal[2] = std::nan("");
  EXPECT_EQ(searchPath(order).status, PlanStatus::kGoalInCollision);
}

TEST(FmtStar, GivesUpWhenHardlyAnythingIsFree) {
  const SearchOrder all = orderFor(nothingInTheWay);
  const SearchOrder order = orderFor([&](const UnitState& x) { return x == all.task.start || x == all.task.goal; });
  EXPECT_EQ(searchPath(order).status, PlanStatus::kNoPath);
}

TEST(FmtStar, StopsWhenTold) {
  SearchOrder order = orderFor(outsideWall);
  int polls = 0;
  order.task.stop = [&] { return ++polls > 100; };
  EXPECT_EQ(searchPath(order).status, PlanStatus::kTimeLimit);
}

/** Whether a path has the edge from `a` to `b`. */
bool hasEdge(const Path& path, const UnitState& a, const UnitState& b) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (path[i - 1] == a && path[i] == b) return true;
  }
  return false;
}

TEST(FmtStar, GoesOnFromTheTreeAsItStandsWhenAPathIsRefused) {
  // GIVEN a judge that refuses the last edge of the first five paths
  SearchOrder order = orderFor(outsideWall);
  order.settings.samples = order.settings.max_samples = 1000;
  const SearchOutcome at_once = searchPath(order);
  std::vector<Path> refused;
  order.judge = [&](const Path& path) -> PathVerdict {
    for (const Path& before : refused)
      EXPECT_FALSE(hasEdge(path, before[before.size() - 2], before.back()))
          << "an edge that the judge refused comes again";
    if (refused.size() == 5) return {};
    refused.push_back(path);
    return {false, path.size() - 2};
  };
  const SearchOutcome outcome = searchPath(order);
  // THEN another path is found without more samples, and with much less work than five searches
  ASSERT_EQ(outcome.status, PlanStatus::kSuccess);
  EXPECT_EQ(outcome.fmt.refusals, 5u);
  EXPECT_EQ(outcome.fmt.samples, 1000u);
  EXPECT_TRUE(isOutsideWallThroughout(outcome.path));
  EXPECT_LT(outcome.counts.cost_evaluations + outcome.counts.edge_checks,
            2 * (at_once.counts.cost_evaluations + at_once.counts.edge_checks));
}

TEST(FmtStar, CutsOffWhatHangsOnARefusedEdgeAndFindsItAnotherParent) {
  // GIVEN a judge that refuses the first edge of each path, on which most of the tree depends
  SearchOrder order = orderFor(outsideWall);
  int refusals = 0;
  order.judge = [&](const Path&) -> PathVerdict { return {++refusals > 8, 0}; };
  const SearchOutcome outcome = searchPath(order);
  ASSERT_EQ(outcome.status, PlanStatus::kSuccess);
  EXPECT_GT(outcome.fmt.detached, 8u);
  EXPECT_TRUE(isOutsideWallThroughout(outcome.path));
}

TEST(FmtStar, SaysSoWhenEveryPathIsRefused) {
  SearchOrder order = orderFor(outsideWall);
  order.settings.max_refusals = 7;
  order.judge = [](const Path&) -> PathVerdict { return {false, 0}; };
  const SearchOutcome outcome = searchPath(order);
  EXPECT_EQ(outcome.status, PlanStatus::kDynamicsInfeasible);
  EXPECT_EQ(outcome.fmt.refusals, 7u);
}

TEST(OmplPlanners, SolveTheSameProblem) {
  for (const char* planner : kPlannerNames) {
    SearchOrder order = orderFor(outsideWall);
    order.planner = planner;
    order.settings.samples = 20000;  // draws; the two FMT planners take all their samples at the start
    if (order.planner == "FMTstar" || order.planner == "FMT") order.settings.samples = 500;
    order.stops_on_draws = true;
    const SearchOutcome outcome = searchPath(order);
    ASSERT_EQ(outcome.status, PlanStatus::kSuccess) << planner;
    EXPECT_EQ(outcome.path.front(), order.task.start) << planner;
    EXPECT_EQ(outcome.path.back(), order.task.goal) << planner;
    EXPECT_TRUE(isOutsideWallThroughout(outcome.path)) << planner;
    EXPECT_GT(outcome.counts.edge_checks, 0u) << planner;
  }
}

TEST(OmplPlanners, GiveTheSamePathForTheSameSeed) {
  for (const char* planner : kPlannerNames) {
    if (std::string(planner) == "PRMstar") continue;  // runs a thread
    SearchOrder order = orderFor(outsideWall);
    order.planner = planner;
    order.settings.samples = std::string(planner).find("FMT") == 0 ? 500 : 20000;
    order.stops_on_draws = true;
    EXPECT_EQ(searchPath(order).path, searchPath(order).path) << planner;
  }
}

TEST(OmplPlanners, AnytimeOnesGetBetterUntilTheyAreStopped) {
  SearchOrder order = orderFor(outsideWall);
  order.planner = "RRTstar";
  order.stops_on_draws = true;
  order.settings.samples = 2500;
  const SearchOutcome first = searchPath(order);
  order.until_stopped = true;
  const SearchOutcome best = searchPath(order);
  ASSERT_EQ(best.status, PlanStatus::kSuccess);
  EXPECT_GT(best.counts.draws, first.counts.draws);
  EXPECT_LT(length(best.path), length(first.path));
}

TEST(OmplPlanners, LoseARefusedEdgeToo) {
  SearchOrder order = orderFor(nothingInTheWay);
  order.planner = "RRTConnect";
  order.settings.samples = 5000;
  order.stops_on_draws = true;
  const SearchOutcome straight = searchPath(order);
  Path refused;
  order.judge = [&](const Path& path) -> PathVerdict {
    if (!refused.empty()) return {};
    refused = path;
    return {false, 0};
  };
  const SearchOutcome outcome = searchPath(order);
  ASSERT_EQ(outcome.status, PlanStatus::kSuccess);
  EXPECT_EQ(refused, straight.path);
  EXPECT_FALSE(hasEdge(outcome.path, refused[0], refused[1]));
}

TEST(OmplPlanners, AnUnknownNameIsRefused) {
  SearchOrder order = orderFor(nothingInTheWay);
  order.planner = "KPIECE";
  EXPECT_THROW(searchPath(order), std::invalid_argument);
}

TEST(EdgeCheck, VisitsBothEndsAndEveryStepOnce) {
  for (const double edge_length : {0.0, 0.004, 0.01, 0.13, 0.317, 0.64}) {
    std::vector<double> visited;
    const UnitState a{0.1, 0, 0, 0, 0, 0}, b{0.1 + edge_length, 0, 0, 0, 0, 0};
    EXPECT_TRUE(isEdgeFree(a, b, 0.01, [&](const UnitState& x) {
      visited.push_back(x[0]);
      return true;
    }));
    std::sort(visited.begin(), visited.end());
    EXPECT_EQ(visited.front(), a[0]);
    EXPECT_EQ(visited.back(), b[0]);
    const auto steps = static_cast<std::size_t>(std::max(1.0, std::ceil(edge_length / 0.01 - 1e-9)));
    EXPECT_NEAR(static_cast<double>(visited.size()), static_cast<double>(steps + 1), 1.0);
    for (std::size_t i = 1; i < visited.size(); ++i) {
      EXPECT_LE(visited[i] - visited[i - 1], 0.01 + 1e-12);
      EXPECT_TRUE(edge_length == 0.0 || visited[i] - visited[i - 1] > 1e-6) << "no place is visited twice";
    }
  }
}

TEST(EdgeCheck, FindsAnObstacleAnywhereOnTheEdge) {
  const UnitState a{}, b{1, 0, 0, 0, 0, 0};
  for (int k = 0; k <= 100; ++k) {
    const double wall = k / 100.0;
    EXPECT_FALSE(isEdgeFree(a, b, 0.01, [&](const UnitState& x) { return std::abs(x[0] - wall) > 0.0051; })) << wall;
  }
}

}  // namespace
}  // namespace raven2_trainer::planning
