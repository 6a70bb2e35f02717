#include "planning/goal_search.h"

#include <gtest/gtest.h>

#include "planning_fixtures.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "support/effort.h"

namespace raven2_trainer::planning {
namespace {

const JointArray kHome = test::geometry().home;

GoalChoice find(const std::function<bool(const UnitState&)>& is_free, const std::function<bool()>& stop) {
  const ArmGeometry geometry = test::geometry();
  const JointSpace space(geometry, kinematics::jawOpening(kHome));
  const Vector3 tip = kinematics::forward(geometry, Arm::kGold, kHome).p;
  return findGoal(geometry, Arm::kGold, space, kHome, tip, is_free, stop);
}

TEST(GoalSearch, TakesTheNearestFreeCandidate) {
  const GoalChoice nearest = find([](const UnitState&) { return true; }, [] { return false; });
  ASSERT_EQ(nearest.status, PlanStatus::kSuccess);
  const UnitState start = JointSpace(test::geometry(), kinematics::jawOpening(kHome)).toUnit(kHome);
  EXPECT_LT(distance(nearest.goal, start), 1e-6) << "the tip is already at the goal";
}

TEST(GoalSearch, ReachesTheTipsOfRandomJoints) {
  const ArmGeometry geometry = test::geometry();
  const JointSpace space(geometry, kinematics::jawOpening(kHome));
  Random random(21);
  const auto tips = static_cast<int>(testing::effort(125, 500));
  int missed = 0;
  for (const Arm arm : kArms) {
    for (int i = 0; i < tips; ++i) {
      UnitState unit;
      for (double& x : unit)
        x = random.uniform(0.02, 0.98);
      const Vector3 tip = kinematics::forward(geometry, arm, space.toJoints(unit)).p;
      const GoalChoice found = findGoal(
          geometry, arm, space, kHome, tip, [](const UnitState&) { return true; }, [] { return false; });
      missed += found.status == PlanStatus::kSuccess ? 0 : 1;
      if (found.status != PlanStatus::kSuccess) continue;
      EXPECT_TRUE(space.contains(found.goal, 0.0));
      EXPECT_LT((kinematics::forward(geometry, arm, space.toJoints(found.goal)).p - tip).norm(), 1e-6);
    }
  }
  EXPECT_LE(1000 * missed, 15 * 2 * tips)
      << "tips at the very edge, where only rolls and wrists between the tried ones reach";
  RecordProperty(testing::isFull() ? "missed_of_1000" : "missed_of_250", missed);
}

TEST(GoalSearch, SaysSoWhereNoPoseReaches) {
  const ArmGeometry geometry = test::geometry();
  const JointSpace space(geometry, kinematics::jawOpening(kHome));
  const GoalChoice found = findGoal(
      geometry, Arm::kGold, space, kHome, Vector3(0.0, 0.0, 2.0), [](const UnitState&) { return true; },
      [] { return false; });
  EXPECT_EQ(found.status, PlanStatus::kGoalUnreachable);
}

TEST(GoalSearch, StopsWithinOneCandidateWhereverItIsTold) {
  // GIVEN candidates that all touch: a complete search tries each of them
  int polls = 0, tries = 0;
  const auto touches = [&](const UnitState&) { return ++tries < 0; };
  ASSERT_EQ(find(touches, [&] { return ++polls < 0; }).status, PlanStatus::kGoalInCollision);
  ASSERT_GT(tries, 10);
  // WHEN one of its polls says stop THEN that poll is the last, except for one at the end, and the search has no goal
  const int all = polls;
  for (int last = 1; last <= all; last += 7) {
    polls = tries = 0;
    int tries_after = 0;
    const auto touches_after = [&](const UnitState&) {
      if (polls >= last) ++tries_after;
      return false;
    };
    EXPECT_EQ(find(touches_after, [&] { return ++polls >= last; }).status, PlanStatus::kNoPath);
    EXPECT_EQ(tries_after, 0);
    EXPECT_LE(polls, last + 1);
  }
}

TEST(GoalSearch, TriesTheCandidatesFromTheNearestOn) {
  // GIVEN candidates that all touch, so that each is tried: those of the poses, then those of the joints
  const UnitState start = JointSpace(test::geometry(), kinematics::jawOpening(kHome)).toUnit(kHome);
  int tries = 0, begun_anew = 0;
  double last = 0.0;
  const auto touches = [&](const UnitState& unit) {
    const double far = distance(unit, start);
    if (far < last - 1e-12) ++begun_anew;
    last = far;
    ++tries;
    return false;
  };
  ASSERT_EQ(find(touches, [] { return false; }).status, PlanStatus::kGoalInCollision);
  EXPECT_GT(tries, 10);
  EXPECT_LE(begun_anew, 1) << "where the second list begins";
}

}  // namespace
}  // namespace raven2_trainer::planning
