#include <gtest/gtest.h>

#include "planning/arm_collision.h"
#include "planning/joint_space.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/planning/path_planner.h"
#include "support/effort.h"

// Tests plans with the shipped robot, scene and configuration, from deep inside the dome to the ring (paper, 3.3).

namespace raven2_trainer::planning {
namespace {

const std::atomic<bool> kGoOn{false};

struct Trainer {
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  model::RavenModel raven = model::loadRavenModel(config);
  model::SceneModel scene = model::loadSceneModel(config);
};

const Trainer& trainer() {
  static const Trainer loaded;
  return loaded;
}

const ArmGeometry& geometry() {
  return trainer().raven.arms.geometry;
}

/** Gold arm under the lid behind the left wire, tip near (49, 36, 21) mm; green at home. */
PlanRequest insideTheDome() {
  PlanRequest request;
  request.start = {0.78, 1.62, 0.335, 0.06, -0.015, kPi / 4, kPi / 4};
  request.other = geometry().home;
  return request;
}

Vector3 tip(Arm arm, const JointArray& q) {
  return at(trainer().raven.X_WB, arm) * kinematics::forward(geometry(), arm, q).p;
}

/** Whether an edge touches nothing, without the clearance, at a tenth of the planner's step. */
bool isFreeOnCloseLook(const PathPlanner& judge, const PlanRequest& request, const JointArray& a, const JointArray& b) {
  const JointSpace space(geometry(), kinematics::jawOpening(a));
  const UnitState from = space.toUnit(a), to = space.toUnit(b);
  const int count = static_cast<int>(10.0 * distance(from, to) / trainer().config.planner.edge_step) + 1;
  for (int k = 0; k <= count; ++k) {
    const JointArray q = space.toJoints(interpolate(from, to, k / static_cast<double>(count)));
    if (judge.inCollision(request.arm, q, request.other)) return false;
  }
  return true;
}

/** Length in the cube over which a path is nearer than 8 mm to any object, by FCL. */
double nearness(const PlanResult& plan) {
  static const SceneObstacles obstacles(trainer().scene);
  ArmCollision grown(trainer().raven, obstacles, Arm::kGold, 0.008);
  grown.placeOther(geometry().home);
  const JointSpace space(geometry(), kinematics::jawOpening(plan.waypoints[0]));
  double sum = 0.0;
  for (std::size_t i = 1; i < plan.waypoint_count; ++i) {
    const UnitState a = space.toUnit(plan.waypoints[i - 1]), b = space.toUnit(plan.waypoints[i]);
    for (int k = 0; k < 100; ++k)
      sum += grown.touches(space.toJoints(interpolate(a, b, (k + 0.5) / 100))) ? distance(a, b) / 100 : 0.0;
  }
  return sum;
}

TEST(FrsScene, HomeIsFreeForBothArms) {
  const PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner);
  for (const Arm arm : kArms)
    EXPECT_FALSE(planner.inCollision(arm, geometry().home, geometry().home)) << name(arm);
}

TEST(FrsScene, TheStartLiesInsideTheDome) {
  const Vector3 start = tip(Arm::kGold, insideTheDome().start);
  EXPECT_GT(start.x(), 0.012 + 0.02);  // under the lid, which covers x beyond 12 mm (meshes/dimensions.yaml)
  EXPECT_LT(start.z(), 0.025);         // lower than the towers
}

TEST(FrsScene, EverySeedFindsTheWayToTheRing) {
  PlannerConfig bare = trainer().config.planner;
  bare.clearance = 0.0;
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner, trainer().config.model);
  const PathPlanner judge(trainer().raven, trainer().scene, bare);
  const PlanRequest request = insideTheDome();
  const auto seeds = static_cast<std::uint64_t>(testing::effort(8, 20));
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const PlanResult result = planner.plan(request, seed, true, kGoOn);
    ASSERT_EQ(result.status, PlanStatus::kSuccess) << "seed " << seed;
    EXPECT_GT(result.waypoint_count, 2u) << "an obstacle blocks the straight path";
    EXPECT_GT(result.clearance, 0.0) << "the dynamics follow the path, seed " << seed;
    EXPECT_GT(result.tracking_error, 0.0);
    EXPECT_LT(result.tracking_error, 0.015);
    const JointArray& last = result.waypoints[result.waypoint_count - 1];
    EXPECT_LT((tip(Arm::kGold, last) - toEigen(trainer().config.planner.goal_W)).norm(), 1e-9);
    for (std::size_t i = 1; i < result.waypoint_count; ++i)
      EXPECT_TRUE(isFreeOnCloseLook(judge, request, result.waypoints[i - 1], result.waypoints[i])) << "seed " << seed;
  }
}

TEST(FrsScene, PathsThatTheArmDoesNotFollowAreRefusedForThatReason) {
  // GIVEN a tip that may leave its path by 0.1 mm only, which no arm achieves
  PlannerConfig few = trainer().config.planner;
  few.max_rollouts = 3;
  few.max_tracking_error = 1e-4;
  few.max_samples = few.samples;
  PathPlanner planner(trainer().raven, trainer().scene, few, trainer().config.model);
  PlanStatistics statistics;
  const PlanResult result = planner.plan(insideTheDome(), 1, true, kGoOn, defaultOptions(few), &statistics);
  // THEN no path is returned, and the reason is the dynamics, neither the start nor the search
  EXPECT_EQ(result.status, PlanStatus::kDynamicsInfeasible);
  EXPECT_EQ(result.waypoint_count, 0u);
  EXPECT_GE(statistics.failed_rollouts, 3u);
  EXPECT_EQ(planner.progress().rollouts.load(), statistics.rollouts);
}

TEST(FrsScene, AModelThatBreaksDownIsAFailureAndNoVerdictOnThePath) {
  // GIVEN motors so strong and stiff that ODE gives up on the first error of a path
  ModelConfig mighty = trainer().config.model;
  for (JointGains& gains : mighty.gains)
    gains.kp = gains.limit = 1e300;
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner, mighty);
  for (int i = 0; i < 2; ++i) {
    const PlanResult result = planner.plan(insideTheDome(), 1, true, kGoOn);
    EXPECT_EQ(result.status, PlanStatus::kFailed) << kPlanStatusNames[static_cast<std::size_t>(result.status)];
    EXPECT_EQ(result.waypoint_count, 0u);
  }
}

TEST(FrsScene, TheClearanceTermKeepsPathsAwayFromThings) {
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner, trainer().config.model);
  PlanOptions options = defaultOptions(trainer().config.planner);
  double with = 0.0, without = 0.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    PlanStatistics statistics;
    options.eta_clearance = 1.0;
    const PlanResult wide = planner.plan(insideTheDome(), seed, true, kGoOn, options, &statistics);
    ASSERT_EQ(wide.status, PlanStatus::kSuccess);
    EXPECT_GT(statistics.clearance_cost, 0.0) << "the path starts 2.5 mm from obstacles";
    EXPECT_GT(statistics.clearance_integrals, 0u);
    options.eta_clearance = 0.0;
    const PlanResult narrow = planner.plan(insideTheDome(), seed, true, kGoOn, options, &statistics);
    ASSERT_EQ(narrow.status, PlanStatus::kSuccess);
    EXPECT_EQ(statistics.clearance_cost, 0.0);
    EXPECT_EQ(statistics.clearance_integrals, 0u);
    with += nearness(wide);
    without += nearness(narrow);
  }
  EXPECT_LT(with, without);
}

TEST(FrsScene, BothArmsReachTheRingFromHome) {
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner);
  for (const Arm arm : kArms) {
    PlanRequest request = insideTheDome();
    request.arm = arm;
    request.start = geometry().home;
    EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kSuccess) << name(arm);
  }
}

TEST(FrsScene, TheStandIsAnObstacleTheRingIsNot) {
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner);
  PlanRequest request = insideTheDome();
  request.start = geometry().home;
  request.goal = GoalKind::kTip;
  request.goal_W = {0.012, 0.0, 0.010};  // [m] inside the peg
  EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kGoalInCollision);
  request.goal_W = {0.012 - 0.009, 0.009, 0.022};  // [m] jaws about the ring's corner
  EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kSuccess);
}

}  // namespace
}  // namespace raven2_trainer::planning
