#include "planning/path_improvement.h"

#include <gtest/gtest.h>

#include "planning/planning_problem.h"
#include "planning_fixtures.h"

namespace raven2_trainer::planning {
namespace {

using Path = std::vector<UnitState>;

class PathImprovement : public ::testing::Test {
 protected:
  PathImprovement() {
    task_.cost = &length_;
    task_.is_edge_free = [this](const UnitState& a, const UnitState& b) {
      return isEdgeFree(a, b, 0.001, [this](const UnitState& x) { return is_free_(x); });
    };
    task_.stop = [] { return false; };
    task_.attempts = 500;
    task_.seed = 1;
  }

  static double lengthOf(const Path& path) {
    double sum = 0.0;
    for (std::size_t i = 1; i < path.size(); ++i)
      sum += distance(path[i - 1], path[i]);
    return sum;
  }

  bool isFree(const Path& path) const {
    for (std::size_t i = 1; i < path.size(); ++i) {
      if (!isEdgeFree(path[i - 1], path[i], 0.001, is_free_)) return false;
    }
    return true;
  }

  const MotionCost length_{test::geometry(),      Arm::kGold,           JointSpace(test::geometry(), 0.5),
                           test::plannerConfig(), {1.0, 0.0, 0.0, 1.0}, ClearanceFunction{}};
  std::function<bool(const UnitState&)> is_free_ = [](const UnitState&) { return true; };
  ImprovementTask task_;
  const Path zigzag_{{0.1, 0.5, 0.5, 0.5, 0.5, 0.5},
                     {0.3, 0.9, 0.2, 0.5, 0.5, 0.5},
                     {0.6, 0.8, 0.5, 0.1, 0.5, 0.5},
                     {0.9, 0.5, 0.5, 0.5, 0.5, 0.5}};
};

TEST_F(PathImprovement, MakesTheStraightLineWhereNothingIsInTheWay) {
  EXPECT_EQ(improvePath(zigzag_, task_), (Path{zigzag_.front(), zigzag_.back()}));
}

TEST_F(PathImprovement, ComesNearTheShortestWayRoundACorner) {
  // GIVEN a wall at x0 = 0.5 that ends at x1 = 0.7: the shortest path bends there and nowhere else
  is_free_ = [](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.01 || x[1] > 0.7; };
  ASSERT_TRUE(isFree(zigzag_));
  const double shortest = 2 * std::hypot(0.39, 0.2) + 0.02;
  const Path improved = improvePath(zigzag_, task_);
  EXPECT_TRUE(isFree(improved));
  EXPECT_GE(lengthOf(improved), shortest - 1e-3);
  EXPECT_LT(lengthOf(improved), 1.03 * shortest);
  EXPECT_EQ(improved.front(), zigzag_.front());
  EXPECT_EQ(improved.back(), zigzag_.back());
}

TEST_F(PathImprovement, LeavesThePathAloneWithoutAttemptsOrWaypoints) {
  task_.attempts = 0;
  EXPECT_EQ(improvePath(zigzag_, task_), zigzag_);
  const Path edge{zigzag_.front(), zigzag_.back()};
  task_.attempts = 100;
  EXPECT_EQ(improvePath(edge, task_), edge);
}

TEST_F(PathImprovement, StopsWhenToldAndKeepsWhatWasGained) {
  // GIVEN a wall that the path must pass, and a stop after so many attempts
  is_free_ = [](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.01 || x[1] > 0.7; };
  const Path whole = improvePath(zigzag_, task_);
  double before = lengthOf(zigzag_);
  for (const std::uint32_t attempts : {1U, 20U, 100U}) {
    std::uint32_t polls = 0;
    task_.attempts = 500;
    task_.stop = [&] { return polls++ >= attempts; };
    const Path stopped = improvePath(zigzag_, task_);
    EXPECT_EQ(polls, attempts + 1) << "a poll before each attempt, and none after the stop";
    // THEN the path is that of an improvement with that many attempts
    task_.attempts = attempts;
    task_.stop = [] { return false; };
    EXPECT_EQ(stopped, improvePath(zigzag_, task_)) << attempts;
    EXPECT_NE(stopped, whole) << attempts;
    EXPECT_LT(lengthOf(stopped), before) << attempts;
    before = lengthOf(stopped);
  }
}

TEST_F(PathImprovement, StoppedAtOnceItChecksNoMoreThanWhatMayBeLeftOut) {
  is_free_ = [](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.01 || x[1] > 0.7; };
  std::size_t checks = 0;
  const auto is_edge_free = task_.is_edge_free;
  task_.is_edge_free = [&](const UnitState& a, const UnitState& b) {
    ++checks;
    return is_edge_free(a, b);
  };
  task_.stop = [] { return true; };
  improvePath(zigzag_, task_);
  EXPECT_LE(checks, zigzag_.size() - 2) << "one check for each waypoint between the ends";
}

TEST_F(PathImprovement, NoAttemptMakesItDearerOrUnfree) {
  // GIVEN the corner, and more and more attempts with one seed: no path is dearer than the one before
  is_free_ = [](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.01 || x[1] > 0.7; };
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    task_.seed = seed;
    double before = lengthOf(zigzag_);
    for (std::uint32_t attempts = 1; attempts <= 60; attempts += attempts < 20 ? 1 : 8) {
      task_.attempts = attempts;
      const Path improved = improvePath(zigzag_, task_);
      EXPECT_LE(lengthOf(improved), before * (1 + 1e-12)) << seed << " " << attempts;
      before = lengthOf(improved);
    }
    EXPECT_TRUE(isFree(improvePath(zigzag_, task_))) << seed;
  }
}

TEST_F(PathImprovement, StaysInTheCubeThoughTheWayRoundWouldBeShorterOutside) {
  // GIVEN a wall at x0 = 0.5 that reaches a little out of one side of the cube and far into the cube
  for (const bool upper : {false, true}) {
    const auto depth = [upper](const UnitState& x) { return upper ? 1.0 - x[2] : x[2]; };
    is_free_ = [depth](const UnitState& x) {
      return std::abs(x[0] - 0.5) > 0.01 || depth(x) < -0.02 || depth(x) > 0.3;
    };
    const double side = upper ? 0.98 : 0.02, over = upper ? 0.6 : 0.4;
    const Path path{{0.1, 0.5, side, 0.5, 0.5, 0.5}, {0.5, 0.5, over, 0.5, 0.5, 0.5}, {0.9, 0.5, side, 0.5, 0.5, 0.5}};
    ASSERT_TRUE(isFree(path));
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      task_.seed = seed;
      for (const UnitState& point : improvePath(path, task_)) {
        for (const double x : point)
          EXPECT_TRUE(x >= 0.0 && x <= 1.0) << x;
      }
    }
  }
}

TEST_F(PathImprovement, GivesTheSameForTheSameSeed) {
  is_free_ = [](const UnitState& x) { return std::abs(x[0] - 0.5) > 0.01 || x[1] > 0.7; };
  const Path first = improvePath(zigzag_, task_);
  EXPECT_EQ(improvePath(zigzag_, task_), first);
  task_.seed = 2;
  EXPECT_NE(improvePath(zigzag_, task_), first);
}

}  // namespace
}  // namespace raven2_trainer::planning
