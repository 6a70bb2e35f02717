#include "raven2_trainer/planning/path_planner.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <limits>
#include <thread>

#include "planning/joint_space.h"
#include "planning_fixtures.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "shipped_trainer.h"
#include "support/effort.h"

namespace raven2_trainer::planning {
namespace {

const std::atomic<bool> kGoOn{false};
const JointArray kHome = test::geometry().home;

/** A wall 4 mm thick across x = 12 mm, up to 60 mm: the tip passes above it. */
model::SceneModel wall() {
  return test::scene({test::box({0.004, 0.6, 0.12}, {Matrix3::Identity(), {0.012, 0, 0}})});
}

Vector3 tip(const model::RavenModel& raven, Arm arm, const JointArray& q) {
  return at(raven.X_WB, arm) * kinematics::forward(raven.arms.geometry, arm, q).p;
}

/** Joints between two waypoints, as the follower interpolates them. */
JointArray between(const JointArray& a, const JointArray& b, double s) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = a[j] + s * (b[j] - a[j]);
  return q;
}

/** CPU time [s] of a running thread, which does not include the time of other programs. */
double cpuSeconds(std::thread* thread) {
  clockid_t clock{};
  timespec time{};
  if (pthread_getcpuclockid(thread->native_handle(), &clock) != 0 || clock_gettime(clock, &time) != 0) return -1.0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double ownCpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/** Resets the peak of peakMemory() to the memory that the process holds now. */
void resetPeakMemory() {
  std::FILE* file = std::fopen("/proc/self/clear_refs", "w");
  ASSERT_NE(file, nullptr);
  std::fputs("5", file);
  std::fclose(file);
}

/** Most memory [MiB] that this process held since resetPeakMemory(). */
double peakMemory() {
  double kib = 0.0;
  std::FILE* file = std::fopen("/proc/self/status", "r");
  char line[128];
  while (file != nullptr && std::fgets(line, sizeof(line), file) != nullptr) {
    if (std::strncmp(line, "VmHWM:", 6) == 0) kib = std::strtod(line + 6, nullptr);
  }
  if (file != nullptr) std::fclose(file);
  return kib / 1024.0;
}

class PathPlannerTest : public ::testing::Test {
 protected:
  /** Gold arm, from home (tip at x = 25 mm, 52 mm high) to the other side of the wall. */
  PlanRequest overTheWall() const {
    PlanRequest request;
    request.id = 17;
    request.start = kHome;
    request.other = kHome;
    request.goal = GoalKind::kTip;
    request.goal_W = {-0.015, 0.055, 0.04};
    return request;
  }

  PlanResult plan(const model::SceneModel& scene, const PlanRequest& request, std::uint64_t seed = 1) const {
    return PathPlanner(raven_, scene, config_).plan(request, seed, true, kGoOn);
  }

  PlannerConfig config_ = test::plannerConfig();
  const model::RavenModel raven_ = test::raven();
};

TEST_F(PathPlannerTest, GoesStraightWhereNothingIsInTheWay) {
  config_.eta_length = 1.0;
  config_.eta_acceleration = 0.0;
  PlanRequest request = overTheWall();
  request.goal_W = {0.0, 0.055, 0.05};
  const PlanResult result = plan(test::scene({}), request);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  EXPECT_EQ(result.id, 17u);
  EXPECT_EQ(result.arm, Arm::kGold);
  ASSERT_EQ(result.waypoint_count, 2u);
  EXPECT_EQ(result.waypoints[0], request.start);
  EXPECT_LT((tip(raven_, Arm::kGold, result.waypoints[1]) - toEigen(request.goal_W)).norm(), 1e-9);
  // THEN the cost is the Euclidean distance of the six joints, each over its range
  const ArmGeometry g = test::geometry();
  double sum = 0.0;
  for (std::size_t j = kShoulder; j <= kWrist; ++j)
    sum += std::pow((result.waypoints[1][j] - request.start[j]) / (g.q_max[j] - g.q_min[j]), 2);
  // Mid-line at 90 degrees opening: grasper limits of 105 degrees leave it +-60 degrees.
  const double midline = kinematics::jawMidline(result.waypoints[1]) - kinematics::jawMidline(request.start);
  sum += std::pow(midline / (120.0 * kPi / 180.0), 2);
  EXPECT_NEAR(result.cost, std::sqrt(sum), 1e-9);
}

TEST_F(PathPlannerTest, KeepsTheJawOpening) {
  PlanRequest request = overTheWall();
  request.start[kGrasp1] = 0.1;
  request.start[kGrasp2] = 0.3;
  const PlanResult result = plan(wall(), request);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  for (std::size_t i = 0; i < result.waypoint_count; ++i)
    EXPECT_NEAR(kinematics::jawOpening(result.waypoints[i]), 0.4, 1e-12);
}

TEST_F(PathPlannerTest, EveryEdgeOfEveryPlanIsFreeAtTenTimesTheResolution) {
  // GIVEN seeded problems across the wall, both arms in turn, and a check for contact at a tenth of the step
  PlannerConfig bare = config_;
  bare.clearance = 0.0;
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  const PathPlanner judge(raven_, scene, bare);
  Random random(2024);
  int solved = 0;
  const auto problems = static_cast<int>(testing::effort(10, 20));
  for (int problem = 0; problem < problems; ++problem) {
    PlanRequest request = overTheWall();
    request.arm = kArms[static_cast<std::size_t>(problem % 2)];
    const double side = request.arm == Arm::kGold ? 1.0 : -1.0;
    request.goal_W = {random.uniform(-0.02, -0.008), side * random.uniform(0.045, 0.08), random.uniform(0.02, 0.05)};
    request.start[kToolRotation] = random.uniform(-1.0, 1.0);
    const PlanResult result = planner.plan(request, static_cast<std::uint64_t>(problem), true, kGoOn);
    if (result.status != PlanStatus::kSuccess) continue;
    ++solved;
    ASSERT_GT(result.waypoint_count, 2u) << "a direct path would cross the wall";
    for (std::size_t i = 1; i < result.waypoint_count; ++i) {
      const JointArray &a = result.waypoints[i - 1], &b = result.waypoints[i];
      const JointSpace space(raven_.arms.geometry, kinematics::jawOpening(a));
      const int fine = static_cast<int>(10.0 * distance(space.toUnit(a), space.toUnit(b)) / config_.edge_step) + 1;
      for (int k = 0; k <= fine; ++k) {
        ASSERT_FALSE(judge.inCollision(request.arm, between(a, b, k / static_cast<double>(fine)), request.other))
            << "problem " << problem << " edge " << i;
      }
    }
    EXPECT_LT((tip(raven_, request.arm, result.waypoints[result.waypoint_count - 1]) - toEigen(request.goal_W)).norm(),
              1e-9);
  }
  EXPECT_GE(4 * solved, 3 * problems);
}

TEST_F(PathPlannerTest, CostAndArrivalAddUpOverTheEdges) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  const PlanResult result = planner.plan(overTheWall(), 3, true, kGoOn);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  double cost = 0.0, time = 0.0;
  EXPECT_EQ(result.arrival[0], 0.0);
  for (std::size_t i = 1; i < result.waypoint_count; ++i) {
    const JointArray &a = result.waypoints[i - 1], &b = result.waypoints[i];
    JointArray delta{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      delta[j] = b[j] - a[j];
    cost += planner.edgeCost(Arm::kGold, a, b);
    time += control::quinticDuration(delta, config_.velocity_limit, config_.acceleration_limit);
    EXPECT_NEAR(result.arrival[i], time, 1e-12);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_GE(b[j], test::geometry().q_min[j] - 1e-9);
      EXPECT_LE(b[j], test::geometry().q_max[j] + 1e-9);
    }
  }
  EXPECT_NEAR(result.cost, cost, 1e-9);
  EXPECT_GE(result.samples, config_.samples);
}

TEST_F(PathPlannerTest, TheSameSeedGivesTheSameBytes) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  const PlanResult first = planner.plan(overTheWall(), 5, true, kGoOn);
  ASSERT_EQ(first.status, PlanStatus::kSuccess);
  planner.plan(overTheWall(), 6, true, kGoOn);  // a plan before must not matter
  const PlanResult again = planner.plan(overTheWall(), 5, true, kGoOn);
  const PlanResult fresh = plan(scene, overTheWall(), 5);
  EXPECT_EQ(again.waypoints, first.waypoints);
  EXPECT_EQ(again.cost, first.cost);
  EXPECT_EQ(again.arrival, first.arrival);
  EXPECT_EQ(again.planning_time, 0.0);
  EXPECT_EQ(fresh.waypoints, first.waypoints);
}

TEST_F(PathPlannerTest, OtherSeedsGiveOtherPaths) {
  const PlanResult first = plan(wall(), overTheWall(), 5);
  const PlanResult second = plan(wall(), overTheWall(), 6);
  EXPECT_NE(first.waypoints, second.waypoints);
}

TEST_F(PathPlannerTest, LockstepChangesNothingButTheClock) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  const PlanResult lockstep = planner.plan(overTheWall(), 5, true, kGoOn);
  const PlanResult live = planner.plan(overTheWall(), 5, false, kGoOn);
  EXPECT_EQ(live.waypoints, lockstep.waypoints);
  EXPECT_GT(live.planning_time, 0.0);
}

TEST_F(PathPlannerTest, TakesTheGoalOfTheConfigurationIfNoneIsAsked) {
  PlanRequest request = overTheWall();
  request.goal = GoalKind::kDefault;
  config_.goal_W = {-0.01, 0.06, 0.045};
  const PlanResult result = plan(wall(), request);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  const JointArray& last = result.waypoints[result.waypoint_count - 1];
  EXPECT_LT((tip(raven_, Arm::kGold, last) - toEigen(config_.goal_W)).norm(), 1e-9);
}

TEST_F(PathPlannerTest, RefusesAStartThatTouches) {
  const model::SceneModel scene =
      test::scene({test::sphere(0.02, {Matrix3::Identity(), tip(raven_, Arm::kGold, kHome)})});
  const PlanResult result = plan(scene, overTheWall());
  EXPECT_EQ(result.status, PlanStatus::kStartInCollision);
  EXPECT_EQ(result.waypoint_count, 0u);
}

TEST_F(PathPlannerTest, RefusesAStartOutsideTheLimitsOrNotANumber) {
  PlanRequest request = overTheWall();
  request.start[kInsertion] = 0.60;
  EXPECT_EQ(plan(wall(), request).status, PlanStatus::kInvalidStart);
  request = overTheWall();
  request.start[kGrasp1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(plan(wall(), request).status, PlanStatus::kInvalidStart);
  request = overTheWall();
  request.other[kElbow] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(plan(wall(), request).status, PlanStatus::kInvalidStart);
}

TEST_F(PathPlannerTest, RefusesAGoalOutOfReach) {
  PlanRequest request = overTheWall();
  request.goal_W = {0.0, 0.0, 1.0};  // [m] above the remote centre: the tool points down
  EXPECT_EQ(plan(wall(), request).status, PlanStatus::kGoalUnreachable);
  request.goal_W[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(plan(wall(), request).status, PlanStatus::kGoalUnreachable);
}

TEST_F(PathPlannerTest, RefusesAGoalInsideAnObstacle) {
  PlanRequest request = overTheWall();
  request.goal_W = {0.012, 0.055, 0.04};  // in the wall in any orientation
  EXPECT_EQ(plan(wall(), request).status, PlanStatus::kGoalInCollision);
}

TEST_F(PathPlannerTest, SaysSoWhenThereIsNoWay) {
  // GIVEN a pit around the foot of the remote centre, parted by a wall up to 90 mm. The tool cannot be withdrawn above
  // the wall: the wrist stays 70 mm or more below the remote centre, and the sides keep the shaft within 45 degrees.
  model::RavenModel raven = test::raven();
  raven.arms.geometry.q_max[kInsertion] = 0.40;
  model::SceneModel pit = test::scene({test::box({0.4, 0.004, 0.4}, {Matrix3::Identity(), {0, 0.0143, 0}}),
                                       test::box({0.4, 0.004, 0.4}, {Matrix3::Identity(), {0, 0.1143, 0}})});
  const model::CollisionShape middle = test::box({0.001, 0.1, 0.18}, {Matrix3::Identity(), {0, 0.0643, 0}});
  PlanRequest request = overTheWall();
  request.start[kInsertion] = 0.38;
  request.goal_W = {-0.018, 0.065, 0.03};
  ASSERT_EQ(PathPlanner(raven, pit, config_).plan(request, 1, true, kGoOn).status, PlanStatus::kSuccess);
  // WHEN the wall is added THEN start and goal stay free, but no path joins them
  pit.description.links[0].collisions.push_back(middle);
  pit.X_WL[0] = Pose{};
  config_.max_samples = 1500;
  EXPECT_EQ(PathPlanner(raven, pit, config_).plan(request, 1, true, kGoOn).status, PlanStatus::kNoPath);
}

TEST_F(PathPlannerTest, SaysSoWhenTheTimeIsUp) {
  config_.samples = 100000;
  config_.time_limit = 0.01;
  const model::SceneModel scene = wall();
  const PlanResult result = PathPlanner(raven_, scene, config_).plan(overTheWall(), 1, false, kGoOn);
  EXPECT_EQ(result.status, PlanStatus::kTimeLimit);
  EXPECT_EQ(result.waypoint_count, 0u);
}

TEST_F(PathPlannerTest, IsCancelledBeforeItBegins) {
  const std::atomic<bool> cancel{true};
  const model::SceneModel scene = wall();
  const PlanResult result = PathPlanner(raven_, scene, config_).plan(overTheWall(), 1, true, cancel);
  EXPECT_EQ(result.status, PlanStatus::kCancelled);
  EXPECT_EQ(result.waypoint_count, 0u);
}

TEST_F(PathPlannerTest, IsCancelledOnItsWay) {
  // GIVEN a plan that would take minutes, WHEN another thread cancels it, THEN the plan ends (or the test hangs)
  config_.samples = 100000;
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  std::atomic<bool> cancel{false};
  PlanResult result;
  std::thread worker([&] { result = planner.plan(overTheWall(), 1, true, cancel); });
  cancel = true;
  worker.join();
  EXPECT_EQ(result.status, PlanStatus::kCancelled);
}

TEST_F(PathPlannerTest, ItsPreparationIsGivenUpAndBegunAnew) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  const std::atomic<bool> cancelled{true}, wanted{false};
  EXPECT_THROW(planner.prepare(cancelled), std::runtime_error);
  EXPECT_EQ(planner.plan(overTheWall(), 1, true, cancelled).status, PlanStatus::kCancelled);
  EXPECT_EQ(planner.plan(overTheWall(), 1, true, wanted).status, PlanStatus::kSuccess);
}

/** The paper's problem with the shipped robot and scene: the gold arm under the lid behind the left wire. */
PlanRequest insideTheDome() {
  PlanRequest request;
  request.start = {0.78, 1.62, 0.335, 0.06, -0.015, kPi / 4, kPi / 4};
  request.other = test::trainer().raven.arms.geometry.home;
  return request;
}

/** Cancels a plan once `is_time` is true for its thread. @return [s] of work after that. */
template <typename IsTime>
double workAfterCancel(PathPlanner* planner, const PlanRequest& request, const IsTime& is_time) {
  std::atomic<bool> cancel{false};
  PlanResult result;
  double ended = 0.0;
  std::thread worker([&] {
    result = planner->plan(request, 1, true, cancel);
    ended = ownCpuSeconds();
  });
  while (!is_time(&worker))
    std::this_thread::yield();
  cancel = true;  // before the clock is read: on a busy machine the worker may run on for long in between
  const double told = cpuSeconds(&worker);
  worker.join();
  EXPECT_EQ(result.status, PlanStatus::kCancelled);
  return ended - told;
}

/** True after so many seconds of work, or once the thread has ended. */
auto after(double seconds) {
  return [seconds](std::thread* worker) {
    const double used = cpuSeconds(worker);
    return used < 0.0 || used >= seconds;
  };
}

TEST_F(PathPlannerTest, IsCancelledWithinATenthOfASecondInEveryPhase) {
  double worst = 0.0;
  const auto expectPrompt = [&worst](double work, const char* phase, double when) {
    EXPECT_LT(work, 0.1) << phase << " " << when;
    worst = std::max(worst, work);
  };
  // GIVEN a plan of many seconds: goal search (the first milliseconds), sampling (the first tenths), search
  config_.samples = config_.max_samples = 500000;
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  planner.prepare();
  const auto either = [](std::vector<double> quick, std::vector<double> full) {
    return testing::isFull() ? full : quick;
  };
  for (const double at : either({0.0005, 0.005, 0.03, 0.1, 0.6}, {0.0005, 0.002, 0.005, 0.01, 0.03, 0.1, 3.0}))
    expectPrompt(workAfterCancel(&planner, overTheWall(), after(at)), "search after [s]", at);
  // AND a plan that prepares first, for a tenth of a second: grid, tables of both arms, roll-outs, free volumes
  const test::Trainer& shipped = test::trainer();
  for (const double at : either({0.0, 0.01, 0.03, 0.05}, {0.0, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.07})) {
    PathPlanner fresh(shipped.raven, shipped.scene, shipped.config.planner, shipped.config.model);
    expectPrompt(workAfterCancel(&fresh, insideTheDome(), after(at)), "preparation after [s]", at);
  }
  // AND a plan with endless roll-outs: no tip keeps to its path within a nanometre
  PlannerConfig endless = shipped.config.planner;
  endless.max_tracking_error = 1e-9;
  endless.max_rollouts = 100000;
  for (const double wanted : either({1, 3}, {1, 3, 8})) {
    const auto rollouts = static_cast<std::uint32_t>(wanted);
    PathPlanner fresh(shipped.raven, shipped.scene, endless, shipped.config.model);
    const auto follows = [&](std::thread* worker) {
      return fresh.progress().rollouts.load() >= rollouts || cpuSeconds(worker) < 0.0;
    };
    expectPrompt(workAfterCancel(&fresh, insideTheDome(), follows), "roll-out", rollouts);
  }
  RecordProperty("worst_cancel_us", static_cast<int>(1e6 * worst));
  std::printf("worst: %.1f ms of work after the cancel\n", 1e3 * worst);
}

TEST_F(PathPlannerTest, AnImpossibleGoalFailsAtTheTimeLimitAndInBoundedMemory) {
  // GIVEN the pit of SaysSoWhenThereIsNoWay and far more samples than the time limit allows
  model::RavenModel raven = test::raven();
  raven.arms.geometry.q_max[kInsertion] = 0.40;
  const model::SceneModel pit = test::scene({test::box({0.4, 0.004, 0.4}, {Matrix3::Identity(), {0, 0.0143, 0}}),
                                             test::box({0.4, 0.004, 0.4}, {Matrix3::Identity(), {0, 0.1143, 0}}),
                                             test::box({0.001, 0.1, 0.18}, {Matrix3::Identity(), {0, 0.0643, 0}})});
  PlanRequest request = overTheWall();
  request.start[kInsertion] = 0.38;
  request.goal_W = {-0.018, 0.065, 0.03};
  for (const std::uint32_t samples : {2000U, 100000U}) {
    config_.samples = samples;
    config_.time_limit = testing::isFull() ? 5.0 : 0.4;
    PathPlanner planner(raven, pit, config_);
    planner.prepare();
    resetPeakMemory();
    const double before = peakMemory(), begin = ownCpuSeconds();
    const PlanResult result = planner.plan(request, 1, false, kGoOn);
    const double work = ownCpuSeconds() - begin, grown = peakMemory() - before;
    EXPECT_TRUE(result.status == PlanStatus::kNoPath || result.status == PlanStatus::kTimeLimit);
    EXPECT_LT(work, config_.time_limit + 0.1) << "work done";
    EXPECT_LT(grown, 256.0) << "MiB";
    std::printf("%u samples, limit %.1f s: %.2f s of work, %.1f MiB\n", samples, config_.time_limit, work, grown);
  }
}

TEST_F(PathPlannerTest, GoesToJointsAtTheOpeningItHas) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  const PlanResult there = planner.plan(overTheWall(), 1, true, kGoOn);
  ASSERT_EQ(there.status, PlanStatus::kSuccess);
  PlanRequest request = overTheWall();
  request.goal = GoalKind::kJoints;
  request.goal_q = there.waypoints[there.waypoint_count - 1];
  const double midline = kinematics::jawMidline(request.goal_q);
  kinematics::setJaws(midline, 0.1, &request.goal_q);
  const PlanResult result = planner.plan(request, 1, true, kGoOn);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  const JointArray& last = result.waypoints[result.waypoint_count - 1];
  for (std::size_t j = kShoulder; j <= kWrist; ++j)
    EXPECT_NEAR(last[j], request.goal_q[j], 1e-12);
  EXPECT_NEAR(kinematics::jawMidline(last), midline, 1e-12);
  EXPECT_NEAR(kinematics::jawOpening(last), kinematics::jawOpening(kHome), 1e-12);
}

TEST_F(PathPlannerTest, RefusesJointsOutsideTheLimitsNotANumberOrInTheWall) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  PlanRequest request = overTheWall();
  request.goal = GoalKind::kJoints;
  request.goal_q = kHome;
  request.goal_q[kInsertion] = 0.60;
  EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kGoalUnreachable);
  request.goal_q[kInsertion] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kGoalUnreachable);
  request.goal_q = kHome;
  request.goal_q[kGrasp2] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kGoalUnreachable);
  // Home is at x = 25 mm, the wall at 12 mm. Some elbow angle on one side of home's puts the tool into the wall.
  PlannerConfig bare = config_;
  bare.clearance = 0.0;
  const PathPlanner judge(raven_, scene, bare);
  int touching = 0;
  for (double turn = -0.5; turn < 0.5; turn += 0.01) {
    request.goal_q = kHome;
    request.goal_q[kElbow] += turn;
    if (!judge.inCollision(Arm::kGold, request.goal_q, kHome)) continue;
    ++touching;
    EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kGoalInCollision) << turn;
  }
  EXPECT_GT(touching, 0);
}

TEST_F(PathPlannerTest, ChoosesTheArmThatStandsNearerToTheGoal) {
  // GIVEN a goal on the left, where gold works, and one on the right
  const model::SceneModel scene = test::scene({});
  PathPlanner planner(raven_, scene, config_);
  PlanRequest request = overTheWall();
  request.choose_arm = 1;
  for (const Arm asked : kArms) {
    request.arm = asked;
    request.goal_W = {0.0, 0.06, 0.045};
    const PlanResult left = planner.plan(request, 1, true, kGoOn);
    EXPECT_EQ(left.status, PlanStatus::kSuccess);
    EXPECT_EQ(left.arm, Arm::kGold);
    request.goal_W = {0.0, -0.06, 0.045};
    const PlanResult right = planner.plan(request, 1, true, kGoOn);
    EXPECT_EQ(right.status, PlanStatus::kSuccess);
    EXPECT_EQ(right.arm, Arm::kGreen);
    EXPECT_LT((tip(raven_, Arm::kGreen, right.waypoints[right.waypoint_count - 1]) - toEigen(request.goal_W)).norm(),
              1e-9);
  }
  // AND without a choice the requested arm moves
  request.choose_arm = 0;
  request.arm = Arm::kGold;
  EXPECT_EQ(planner.plan(request, 1, true, kGoOn).arm, Arm::kGold);
}

TEST_F(PathPlannerTest, AnArmThatIsChosenGoesAsIfItHadBeenAsked) {
  // GIVEN both arms anywhere, jaws opened by different angles, and a goal that is better for the arm not requested
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  Random random(77);
  int chosen = 0;
  for (int problem = 0; problem < 16; ++problem) {
    const Arm asked = kArms[static_cast<std::size_t>(problem % 2)], better = otherArm(asked);
    PlanRequest request = overTheWall();
    request.arm = asked;
    request.choose_arm = 1;
    request.start = test::randomJointsNear(raven_.arms.geometry, kHome, 0.3, &random);
    request.other = test::randomJointsNear(raven_.arms.geometry, kHome, 0.3, &random);
    request.goal_W = {random.uniform(-0.02, 0.05), better == Arm::kGold ? 0.03 : -0.03, 0.05};
    if (planner.inCollision(asked, request.start, request.other)) continue;
    const auto seed = static_cast<std::uint64_t>(problem);
    const PlanResult result = planner.plan(request, seed, true, kGoOn);
    if (result.arm != better) continue;
    ++chosen;
    // THEN the plan equals that for the chosen arm, with the requested arm as an obstacle at its place
    PlanRequest direct = request;
    direct.choose_arm = 0;
    direct.arm = better;
    std::swap(direct.start, direct.other);
    const PlanResult wanted = planner.plan(direct, seed, true, kGoOn);
    EXPECT_EQ(result.status, wanted.status) << problem;
    EXPECT_EQ(result.waypoints, wanted.waypoints) << problem;
    EXPECT_EQ(result.cost, wanted.cost) << problem;
    if (result.status != PlanStatus::kSuccess) continue;
    EXPECT_EQ(result.waypoints[0], request.other) << problem;
  }
  EXPECT_GE(chosen, 5);
}

TEST_F(PathPlannerTest, AnArmThatIsChosenKeepsOffTheOneThatWasAsked) {
  for (const Arm asked : kArms) {
    // GIVEN an arm whose tip is at a goal that both arms reach. Its shaft touches an object, so that it cannot move.
    PlanRequest request = overTheWall();
    request.arm = asked;
    request.goal_W = {0.02, 0.0, 0.05};
    const PlanResult there = plan(test::scene({}), request);
    ASSERT_EQ(there.status, PlanStatus::kSuccess);
    request.start = there.waypoints[there.waypoint_count - 1];
    const Vector3 goal = tip(raven_, asked, request.start);
    const Vector3 shaft = goal + 0.05 * (at(raven_.X_WB, asked).p - goal).normalized();
    const model::SceneModel scene = test::scene({test::sphere(0.003, {Matrix3::Identity(), shaft})});
    PathPlanner planner(raven_, scene, config_);
    PlanRequest elsewhere = request;
    elsewhere.arm = otherArm(asked);
    std::swap(elsewhere.start, elsewhere.other);
    elsewhere.other = kHome;
    ASSERT_EQ(planner.plan(elsewhere, 1, true, kGoOn).status, PlanStatus::kSuccess)
        << "without the requested arm there the goal is free";
    // WHEN the planner chooses
    request.choose_arm = 1;
    const PlanResult result = planner.plan(request, 1, true, kGoOn);
    // THEN it chooses the other arm, which cannot reach the goal
    EXPECT_EQ(result.arm, otherArm(asked));
    EXPECT_EQ(result.status, PlanStatus::kGoalInCollision);
  }
}

TEST_F(PathPlannerTest, AnArmThatStandsBeyondItsLimitsIsNotChosen) {
  const model::SceneModel scene = test::scene({});
  PathPlanner planner(raven_, scene, config_);
  for (const Arm asked : kArms) {
    PlanRequest request = overTheWall();
    request.arm = asked;
    request.choose_arm = 1;
    request.goal_W = {0.0, asked == Arm::kGold ? -0.03 : 0.03, 0.05};
    ASSERT_EQ(planner.plan(request, 1, true, kGoOn).arm, otherArm(asked));
    request.other[kInsertion] = 0.57;
    EXPECT_EQ(planner.plan(request, 1, true, kGoOn).arm, asked);
  }
}

TEST_F(PathPlannerTest, TheOtherArmIsChosenIfTheAskedOneStandsBeyondItsLimits) {
  const model::SceneModel scene = test::scene({});
  PathPlanner planner(raven_, scene, config_);
  for (const Arm asked : kArms) {
    PlanRequest request = overTheWall();
    request.arm = asked;
    request.choose_arm = 1;
    request.goal_W = {0.0, asked == Arm::kGold ? -0.03 : 0.03, 0.05};
    request.start[kInsertion] = 0.57;
    const PlanResult result = planner.plan(request, 1, true, kGoOn);
    EXPECT_EQ(result.status, PlanStatus::kSuccess) << name(asked);
    EXPECT_EQ(result.arm, otherArm(asked));
    request.goal_W = {0.0, 0.0, 1.0};
    EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kInvalidStart) << "neither can go";
  }
}

TEST_F(PathPlannerTest, AStartALittleBeyondALimitIsWhereThePathBegins) {
  // GIVEN an arm that settled a thousandth of a joint's range beyond one of its limits: this is less than kStartSlack
  const model::SceneModel scene = test::scene({});
  PathPlanner planner(raven_, scene, config_);
  const ArmGeometry& g = raven_.arms.geometry;
  for (const Joint joint : {kShoulder, kElbow, kInsertion, kToolRotation, kWrist}) {
    for (const bool upper : {false, true}) {
      PlanRequest request = overTheWall();
      const double range = g.q_max[joint] - g.q_min[joint];
      request.start[joint] = upper ? g.q_max[joint] + 0.001 * range : g.q_min[joint] - 0.001 * range;
      request.goal = GoalKind::kJoints;
      request.goal_q = kHome;
      const PlanResult result = planner.plan(request, 1, true, kGoOn);
      ASSERT_EQ(result.status, PlanStatus::kSuccess) << kJointNames[joint] << upper;
      EXPECT_EQ(result.waypoints[0], request.start) << kJointNames[joint] << upper;
      // AND a goal that far beyond the limit counts as the limit itself
      std::swap(request.start, request.goal_q);
      const PlanResult back = planner.plan(request, 1, true, kGoOn);
      ASSERT_EQ(back.status, PlanStatus::kSuccess) << kJointNames[joint] << upper;
      EXPECT_NEAR(back.waypoints[back.waypoint_count - 1][joint], upper ? g.q_max[joint] : g.q_min[joint], 1e-12);
    }
  }
}

TEST_F(PathPlannerTest, EachArmIsJudgedForItself) {
  for (const Arm arm : kArms) {
    const model::SceneModel scene =
        test::scene({test::sphere(0.01, {Matrix3::Identity(), tip(raven_, arm, kHome)})});
    const PathPlanner planner(raven_, scene, config_);
    EXPECT_TRUE(planner.inCollision(arm, kHome, kHome)) << name(arm);
    EXPECT_FALSE(planner.inCollision(otherArm(arm), kHome, kHome)) << name(arm);
  }
}

TEST_F(PathPlannerTest, WeightsAndTimesThatAreNoneFail) {
  const model::SceneModel scene = test::scene({});
  PathPlanner planner(raven_, scene, config_);
  for (double PlanOptions::*number : {&PlanOptions::eta_length, &PlanOptions::eta_acceleration,
                                      &PlanOptions::eta_clearance, &PlanOptions::time_limit}) {
    for (const double bad : {-1e-9, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
      PlanOptions options = defaultOptions(config_);
      options.*number = bad;
      EXPECT_EQ(planner.plan(overTheWall(), 1, true, kGoOn, options).status, PlanStatus::kFailed) << bad;
    }
  }
}

TEST_F(PathPlannerTest, SaysWhyNeitherArmCanGo) {
  const model::SceneModel scene = test::scene({});
  PathPlanner planner(raven_, scene, config_);
  PlanRequest request = overTheWall();
  request.choose_arm = 1;
  request.goal_W = {0.0, 0.0, 1.0};
  EXPECT_EQ(planner.plan(request, 1, true, kGoOn).status, PlanStatus::kGoalUnreachable);
}

TEST_F(PathPlannerTest, LeavesAPlaceThatIsNearerThanTheClearance) {
  // GIVEN an obstacle 1 mm from the tool's bar at home, half of the usual clearance
  const Vector3 home = tip(raven_, Arm::kGold, kHome);
  model::SceneModel scene = test::scene({test::sphere(0.004, {Matrix3::Identity(), home})});
  PlannerConfig bare = config_;
  bare.clearance = 0.0;
  for (double x = 0.0; x < 0.05; x += 0.0005) {
    scene.X_WL[0].p = Vector3(x, 0.0, 0.0);
    if (!PathPlanner(raven_, scene, bare).inCollision(Arm::kGold, kHome, kHome)) break;
  }
  ASSERT_TRUE(PathPlanner(raven_, scene, config_).inCollision(Arm::kGold, kHome, kHome));
  PlanRequest request = overTheWall();
  request.goal_W = {-0.01, 0.055, 0.05};
  const PlanResult result = plan(scene, request);
  EXPECT_EQ(result.status, PlanStatus::kSuccess);
}

TEST_F(PathPlannerTest, TheOptionsOfOnePlanChangeNoOther) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  const PlanResult usual = planner.plan(overTheWall(), 5, true, kGoOn);
  PlanOptions options = defaultOptions(config_);
  PlanStatistics statistics;
  options.samples = options.max_samples = 900;
  options.eta_acceleration = 0.0;
  options.improve_attempts = 0;
  const PlanResult other = planner.plan(overTheWall(), 5, true, kGoOn, options, &statistics);
  ASSERT_EQ(other.status, PlanStatus::kSuccess);
  EXPECT_EQ(other.samples, 900u);
  EXPECT_EQ(statistics.samples, 900u);
  EXPECT_EQ(statistics.plain_cost, statistics.improved_cost);
  EXPECT_EQ(planner.plan(overTheWall(), 5, true, kGoOn).waypoints, usual.waypoints);
}

TEST_F(PathPlannerTest, TellsHowFarItCameAndWhatItCost) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  EXPECT_EQ(planner.progress().samples.load(), 0u);
  PlanStatistics s;
  const PlanResult result = planner.plan(overTheWall(), 5, false, kGoOn, defaultOptions(config_), &s);
  ASSERT_EQ(result.status, PlanStatus::kSuccess);
  EXPECT_EQ(planner.progress().samples.load(), result.samples)
      << "only samples that were kept count, without start and goal";
  EXPECT_EQ(result.samples, config_.samples);
  EXPECT_GT(planner.progress().edges.load(), 0u);
  EXPECT_EQ(planner.progress().best_cost.load(), s.improved_cost);
  EXPECT_NEAR(s.improved_cost, result.cost, 1e-12);
  EXPECT_GE(s.draws, s.samples);
  EXPECT_GT(s.edge_checks, 0u);
  EXPECT_GT(s.cost_evaluations, 0u);
  const double parts =
      s.goal_time + s.sampling_time + s.neighbour_time + s.search_time + s.improvement_time + s.rollout_time;
  EXPECT_NEAR(parts, result.planning_time, 1e-9);
  // In lockstep no value depends on the machine.
  planner.plan(overTheWall(), 5, true, kGoOn, defaultOptions(config_), &s);
  EXPECT_EQ(s.goal_time + s.sampling_time + s.neighbour_time + s.search_time + s.improvement_time, 0.0);
}

TEST_F(PathPlannerTest, ProgressIsOfThePlanThatIsUnderWayOrWasLast) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  ASSERT_EQ(planner.plan(overTheWall(), 5, true, kGoOn).status, PlanStatus::kSuccess);
  const std::uint32_t edges = planner.progress().edges.load();
  ASSERT_GT(edges, 0u);
  ASSERT_GT(planner.progress().best_cost.load(), 0.0);
  planner.plan(overTheWall(), 5, true, kGoOn);
  EXPECT_EQ(planner.progress().edges.load(), edges) << "the count is of the last plan alone";
  PlanRequest nowhere = overTheWall();
  nowhere.start[kInsertion] = 0.60;
  ASSERT_EQ(planner.plan(nowhere, 5, true, kGoOn).status, PlanStatus::kInvalidStart);
  EXPECT_EQ(planner.progress().samples.load(), 0u);
  EXPECT_EQ(planner.progress().edges.load(), 0u);
  EXPECT_EQ(planner.progress().rollouts.load(), 0u);
  EXPECT_EQ(planner.progress().best_cost.load(), 0.0);
}

TEST_F(PathPlannerTest, TakesNoMoreSamplesThanItMayAndTellsHowOftenItAdded) {
  // GIVEN ten samples, whose number grows by half each time: 10, 15, 23, 35, 53, ... up to the limit
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  PlanOptions options = defaultOptions(config_);
  options.samples = 10;
  int added = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    options.max_samples = 40;
    PlanStatistics statistics;
    const PlanResult result = planner.plan(overTheWall(), seed, true, kGoOn, options, &statistics);
    EXPECT_LE(result.samples, 40u) << seed;
    const std::array<std::uint32_t, 5> steps{10, 15, 23, 35, 40};
    ASSERT_LT(statistics.rounds, steps.size());
    EXPECT_EQ(result.samples, steps[statistics.rounds]) << seed;
    added += statistics.rounds > 0 ? 1 : 0;
  }
  EXPECT_GT(added, 0);
}

TEST_F(PathPlannerTest, AddsSamplesWhereTheFirstDoNotDo) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  PlanOptions options = defaultOptions(config_);
  options.samples = 10;
  int failed = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    options.max_samples = 10;
    if (planner.plan(overTheWall(), seed, true, kGoOn, options).status == PlanStatus::kSuccess) continue;
    ++failed;
    options.max_samples = 4000;
    const PlanResult result = planner.plan(overTheWall(), seed, true, kGoOn, options);
    EXPECT_EQ(result.status, PlanStatus::kSuccess) << "seed " << seed;
    EXPECT_GT(result.samples, 10u) << "seed " << seed;
    EXPECT_EQ(planner.progress().samples.load(), result.samples) << "seed " << seed;
  }
  RecordProperty("failed_at_ten", failed);
}

TEST_F(PathPlannerTest, EveryPlannerSolvesIt) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  for (const char* name : kPlannerNames) {
    PlanOptions options = defaultOptions(config_);
    options.planner = name;
    options.eta_clearance = 0.0;  // OMPL's planners evaluate more costs; each would need an integral
    options.samples = std::string(name).find("FMT") == 0 ? 200 : 20000;
    const bool repeats = std::string(name) != "PRMstar";
    const PlanResult result = planner.plan(overTheWall(), 3, repeats, kGoOn, options);
    EXPECT_EQ(result.status, PlanStatus::kSuccess) << name;
  }
}

TEST_F(PathPlannerTest, APlannerThatIsUnknownOrCannotRepeatItselfFails) {
  const model::SceneModel scene = wall();
  PathPlanner planner(raven_, scene, config_);
  PlanOptions options = defaultOptions(config_);
  for (const char* name : {"A*", "PRMstar"}) {
    options.planner = name;
    EXPECT_EQ(planner.plan(overTheWall(), 3, /*lockstep=*/true, kGoOn, options).status, PlanStatus::kFailed) << name;
  }
}

TEST_F(PathPlannerTest, TheConfigurationKnowsTheSamePlanners) {
  // The layer below this one, config/read_planner.cpp, lists the names.
  std::ifstream file(RAVEN2_TRAINER_SOURCE_DIR "/src/config/read_planner.cpp");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::string list;
  for (const char* name : kPlannerNames)
    list += (list.empty() ? "\"" : ", \"") + std::string(name) + "\"";
  EXPECT_NE(text.find("{" + list + "}"), std::string::npos);
}

TEST_F(PathPlannerTest, ThePlannedArmGivesWayToTheOther) {
  // GIVEN the green arm with its tip at gold's goal, from a plan with gold elsewhere
  PlanRequest request = overTheWall();
  request.arm = Arm::kGreen;
  request.goal_W = {0.02, 0.0, 0.05};
  const PlanResult green = plan(test::scene({}), request);
  ASSERT_EQ(green.status, PlanStatus::kSuccess);
  request.arm = Arm::kGold;
  ASSERT_EQ(plan(test::scene({}), request).status, PlanStatus::kSuccess);
  request.other = green.waypoints[green.waypoint_count - 1];
  EXPECT_EQ(plan(test::scene({}), request).status, PlanStatus::kGoalInCollision);
}

}  // namespace
}  // namespace raven2_trainer::planning
