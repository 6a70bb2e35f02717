#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <vector>

#include "planning/joint_space.h"
#include "raven2_trainer/config/load_problem.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/planning/path_planner.h"
#include "shipped_trainer.h"

// Tests that the claims of config/problems are true for the shipped robot and scene.

namespace raven2_trainer::planning {
namespace {

using test::trainer;

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/problems";
const std::atomic<bool> kGoOn{false};

const ArmGeometry& geometry() {
  return trainer().raven.arms.geometry;
}

Vector3 tip(Arm arm, const JointArray& q) {
  return at(trainer().raven.X_WB, arm) * kinematics::forward(geometry(), arm, q).p;
}

PlanRequest problem(const std::string& name) {
  return config::findProblem(kFolder, name, geometry()).request;
}

bool straightLineIsFree(const PathPlanner& judge, const PlanRequest& request, const JointArray& goal) {
  const JointSpace space(geometry(), kinematics::jawOpening(request.start));
  const UnitState from = space.toUnit(request.start), to = space.toUnit(goal);
  const int count = static_cast<int>(distance(from, to) / trainer().config.planner.edge_step) + 1;
  for (int k = 0; k <= count; ++k) {
    const JointArray q = space.toJoints(interpolate(from, to, k / static_cast<double>(count)));
    if (judge.inCollision(request.arm, q, request.other)) return false;
  }
  return true;
}

class Problem : public ::testing::TestWithParam<const char*> {};

TEST_P(Problem, StartAndGoalAreFreeAndTheWayIsWhatItIsSaidToBe) {
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner);
  const PlanRequest request = problem(GetParam());
  ASSERT_FALSE(planner.inCollision(request.arm, request.start, request.other));
  const Arm other_arm = request.arm == Arm::kGold ? Arm::kGreen : Arm::kGold;
  EXPECT_FALSE(planner.inCollision(other_arm, request.other, request.start));
  const PlanResult result = planner.plan(request, 1, true, kGoOn);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  const JointArray& goal = result.waypoints[result.waypoint_count - 1];
  EXPECT_FALSE(planner.inCollision(request.arm, goal, request.other));
  EXPECT_LT((tip(request.arm, goal) - toEigen(request.goal_W)).norm(), 1e-9);
  EXPECT_EQ(straightLineIsFree(planner, request, goal), std::string(GetParam()) == "short_move");
}

INSTANTIATE_TEST_SUITE_P(Solvable,
                         Problem,
                         ::testing::Values("paper", "short_move", "past_tower", "into_dome", "two_arms"),
                         [](const auto& each) { return each.param; });

TEST(ImpossibleProblem, StartAndGoalAreFreeAndNoPathIsFound) {
  PlannerConfig config = trainer().config.planner;
  config.samples = 200;
  config.max_samples = 1500;
  PathPlanner planner(trainer().raven, trainer().scene, config);
  const PlanRequest request = problem("impossible");
  EXPECT_FALSE(planner.inCollision(Arm::kGold, request.start, request.other));
  EXPECT_FALSE(planner.inCollision(Arm::kGold, request.goal_q, request.other));
  EXPECT_FALSE(planner.inCollision(Arm::kGreen, request.other, request.start));
  const PlanResult result = planner.plan(request, 1, true, kGoOn);
  EXPECT_EQ(result.status, PlanStatus::kNoPath) << kPlanStatusNames[static_cast<std::size_t>(result.status)];
}

/** Shoulder, elbow and insertion on a grid; the wrist and the jaws have no bodies, so it is freer than the arm. */
class PositioningGrid {
 public:
  static constexpr int kShoulders = 315, kElbows = 79, kInsertions = 34;  // 5 mrad, 20 mrad, 10 mm

  PositioningGrid(const PlanRequest& request, const JointArray& from) {
    model::RavenModel bare = trainer().raven;
    for (const Joint joint : {kWrist, kGrasp1, kGrasp2})
      bare.description.links[static_cast<std::size_t>(at(bare.links, request.arm)[joint])].collisions.clear();
    const PathPlanner judge(bare, trainer().scene, trainer().config.planner);
    fill(cellOf(from), [&](int cell) { return !judge.inCollision(request.arm, joints(cell, from), request.other); });
  }

  bool isReached(const JointArray& q) const { return reached_[static_cast<std::size_t>(cellOf(q))] == kReached; }
  int reachedCells() const { return static_cast<int>(std::count(reached_.begin(), reached_.end(), kReached)); }

 private:
  enum Mark : char { kUnknown, kBlocked, kReached };
  static constexpr std::array<int, 3> kCounts{kShoulders, kElbows, kInsertions};

  static std::array<int, 3> split(int cell) {
    return {cell / (kElbows * kInsertions), cell / kInsertions % kElbows, cell % kInsertions};
  }

  static int cellOf(const JointArray& q) {
    int cell = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const double share = (q[j] - geometry().q_min[j]) / (geometry().q_max[j] - geometry().q_min[j]);
      cell = cell * kCounts[j] + static_cast<int>(std::lround(share * (kCounts[j] - 1)));
    }
    return cell;
  }

  static JointArray joints(int cell, JointArray q) {
    const std::array<int, 3> index = split(cell);
    for (std::size_t j = 0; j < 3; ++j)
      q[j] = geometry().q_min[j] + index[j] * (geometry().q_max[j] - geometry().q_min[j]) / (kCounts[j] - 1);
    return q;
  }

  /** Fills all free cells that are connected with `first`, also over corners. */
  template <typename IsFree>
  void fill(int first, const IsFree& is_free) {
    std::queue<int> open;
    const auto visit = [&](int cell) {
      Mark& mark = reached_[static_cast<std::size_t>(cell)];
      if (mark != kUnknown) return;
      mark = is_free(cell) ? kReached : kBlocked;
      if (mark == kReached) open.push(cell);
    };
    for (visit(first); !open.empty(); open.pop())
      visitNeighbours(split(open.front()), visit);
  }

  template <typename Visit>
  static void visitNeighbours(const std::array<int, 3>& c, const Visit& visit) {
    for (int a = std::max(0, c[0] - 1); a <= std::min(kShoulders - 1, c[0] + 1); ++a)
      for (int b = std::max(0, c[1] - 1); b <= std::min(kElbows - 1, c[1] + 1); ++b)
        for (int k = std::max(0, c[2] - 1); k <= std::min(kInsertions - 1, c[2] + 1); ++k)
          visit((a * kElbows + b) * kInsertions + k);
  }

  std::vector<Mark> reached_ = std::vector<Mark>(kShoulders * kElbows * kInsertions, kUnknown);
};

TEST(ImpossibleProblem, NoWayLeadsOutOfThePocketOfTheGoal) {
  const PlanRequest request = problem("impossible");
  // The grid is filled from the goal. It proves that the pocket is small and closed.
  const PositioningGrid pocket(request, request.goal_q);
  EXPECT_TRUE(pocket.isReached(request.goal_q));
  EXPECT_GT(pocket.reachedCells(), 500);
  EXPECT_LT(pocket.reachedCells(), 5000);
  EXPECT_FALSE(pocket.isReached(request.start));
}

TEST(ImpossibleProblem, IsPossibleWithoutTheOtherArm) {
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner);
  PlanRequest alone = problem("impossible");
  alone.other = geometry().home;
  EXPECT_EQ(planner.plan(alone, 1, true, kGoOn).status, PlanStatus::kSuccess);
}

}  // namespace
}  // namespace raven2_trainer::planning
