#include "planning/fmt_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raven2_trainer::planning {
namespace {

/** A cube without obstacles, costs by length. */
FmtProblem emptyCube() {
  FmtProblem problem;
  problem.start = {0.2, 0.5, 0.5, 0.5, 0.5, 0.5};
  problem.goal = {0.8, 0.5, 0.5, 0.5, 0.5, 0.5};
  problem.is_valid = [](const UnitState&) { return true; };
  problem.cost = [](const UnitState& a, const UnitState& b) { return distance(a, b); };
  problem.stop = [] { return false; };
  problem.samples = 500;
  problem.radius_multiplier = 1.4;
  problem.edge_step = 0.01;
  problem.seed = 1;
  return problem;
}

/** A wall across the first axis with a gap where the second exceeds 0.8. */
bool outsideWall(const UnitState& x) {
  return std::abs(x[0] - 0.5) > 0.05 || x[1] > 0.8;
}

double length(const std::vector<UnitState>& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    sum += distance(path[i - 1], path[i]);
  return sum;
}

TEST(FmtSearch, ReturnsTheStraightEdgeWhereNothingIsInTheWay) {
  const FmtProblem problem = emptyCube();
  // The goal, 0.6 away, is within the radius of eq. (2): 1.4 x 0.60 at n = 500 (performance.md 2.2).
  const std::vector<UnitState> path = searchFmt(problem);
  ASSERT_EQ(path.size(), 2u);
  EXPECT_EQ(path.front(), problem.start);
  EXPECT_EQ(path.back(), problem.goal);
}

TEST(FmtSearch, FindsTheGapInAWall) {
  FmtProblem problem = emptyCube();
  problem.is_valid = outsideWall;
  for (problem.seed = 1; problem.seed <= 10; ++problem.seed) {
    const std::vector<UnitState> path = searchFmt(problem);
    ASSERT_GE(path.size(), 3u) << "seed " << problem.seed;
    EXPECT_EQ(path.front(), problem.start);
    EXPECT_EQ(path.back(), problem.goal);
    // The shortest way passes the two corners of the gap: sqrt(0.25^2 + 0.3^2) twice and the wall's thickness.
    EXPECT_GE(length(path), 2 * std::hypot(0.25, 0.3) + 0.1);
    for (std::size_t i = 1; i < path.size(); ++i) {
      for (int k = 0; k <= 1000; ++k)
        ASSERT_TRUE(outsideWall(interpolate(path[i - 1], path[i], k / 1000.0))) << "seed " << problem.seed;
    }
  }
}

TEST(FmtSearch, NeighboursAreNearInSpaceWhateverTheCost) {
  // GIVEN a cost a thousand times the length: in units of cost nothing at all is within the radius
  FmtProblem problem = emptyCube();
  problem.is_valid = outsideWall;
  const std::vector<UnitState> by_length = searchFmt(problem);
  problem.cost = [](const UnitState& a, const UnitState& b) { return 1024.0 * distance(a, b); };
  // THEN the same graph is searched and the same path found
  EXPECT_EQ(searchFmt(problem), by_length);
}

TEST(FmtSearch, FollowsTheCost) {
  // GIVEN a cost that punishes moves along the third axis, and a wall that can be passed by the second or the third
  FmtProblem problem = emptyCube();
  problem.is_valid = [](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.05 || x[1] > 0.8 || x[2] > 0.8; };
  const auto travel = [](const std::vector<UnitState>& path, std::size_t axis) {
    double sum = 0.0;
    for (std::size_t i = 1; i < path.size(); ++i)
      sum += std::abs(path[i][axis] - path[i - 1][axis]);
    return sum;
  };
  for (const std::size_t dear : {1, 2}) {
    problem.cost = [dear](const UnitState& a, const UnitState& b) {
      return distance(a, b) + 20.0 * std::abs(a[dear] - b[dear]);
    };
    const std::vector<UnitState> path = searchFmt(problem);
    ASSERT_FALSE(path.empty());
    EXPECT_LT(travel(path, dear), travel(path, 3 - dear));
  }
}

TEST(FmtSearch, GivesTheSamePathForTheSameSeedOnly) {
  FmtProblem problem = emptyCube();
  problem.is_valid = outsideWall;
  const std::vector<UnitState> first = searchFmt(problem);
  EXPECT_EQ(searchFmt(problem), first);
  problem.seed = 2;
  EXPECT_NE(searchFmt(problem), first);
}

TEST(FmtSearch, EndsWithoutAPathBehindAWholeWall) {
  FmtProblem problem = emptyCube();
  problem.is_valid = [](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.05; };
  EXPECT_TRUE(searchFmt(problem).empty());
}

TEST(FmtSearch, SurvivesAnInvalidGoalOrStart) {
  // OMPL 1.5.2 takes the process with it on an invalid goal.
  FmtProblem problem = emptyCube();
  problem.is_valid = [](const UnitState& x) { return x[0] < 0.7; };
  EXPECT_TRUE(searchFmt(problem).empty());
  problem.is_valid = [](const UnitState& x) { return x[0] > 0.3; };
  EXPECT_TRUE(searchFmt(problem).empty());
}

TEST(FmtSearch, GivesUpWhenHardlyAnythingIsFree) {
  FmtProblem problem = emptyCube();
  problem.is_valid = [&](const UnitState& x) { return x == problem.start || x == problem.goal; };
  EXPECT_TRUE(searchFmt(problem).empty());
}

TEST(FmtSearch, StopsWhenTold) {
  FmtProblem problem = emptyCube();
  problem.is_valid = outsideWall;
  int polls = 0;
  problem.stop = [&] { return ++polls > 100; };
  EXPECT_TRUE(searchFmt(problem).empty());
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
      EXPECT_TRUE(edge_length == 0.0 || visited[i] - visited[i - 1] > 1e-6) << "visited twice";
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
