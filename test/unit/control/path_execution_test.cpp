#include "raven2_trainer/control/path_execution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raven2_trainer::control {
namespace {

constexpr JointArray kStart{0.5, 1.5, 0.40, 0.1, 0.0, 0.7, 0.8};
constexpr JointArray kMiddle{0.6, 1.4, 0.41, 0.3, 0.2, 0.6, 0.9};
constexpr JointArray kGoal{0.4, 1.6, 0.38, 0.0, 0.1, 0.8, 0.7};

PlanResult plan() {
  PlanResult result;
  result.id = 3;
  result.status = PlanStatus::kSuccess;
  result.waypoint_count = 3;
  result.waypoints[0] = kStart;
  result.waypoints[1] = kMiddle;
  result.waypoints[2] = kGoal;
  result.arrival[1] = 0.5;
  result.arrival[2] = 1.3;
  return result;
}

ExecutionConfig configuration(double speed = 1.0) {
  ExecutionConfig config;
  config.speed = speed;
  config.hold_time = 0.2;
  return config;
}

/** Greatest difference of any joint. */
double apart(const JointArray& a, const JointArray& b) {
  double most = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    most = std::max(most, std::abs(a[j] - b[j]));
  return most;
}

/** Ticks until the path is over, at most 10 s of them. */
int ticksOf(PathExecution* execution) {
  int ticks = 0;
  for (; !execution->isOver() && ticks < 10000; ++ticks)
    execution->tick(true);
  return ticks;
}

TEST(PathExecution, BeginsWhereTheArmStandsAndIsOnThePathAfterTheHold) {
  PathExecution execution(configuration());
  JointArray from = kStart;
  from[0] += 0.008;
  from[2] -= 0.001;
  execution.start(plan(), from);
  EXPECT_EQ(execution.desired(), from);
  EXPECT_LT(apart(execution.tick(true).q, from), 1e-6) << "from rest";
  for (int i = 1; i < 100; ++i)
    execution.tick(true);
  EXPECT_NEAR(execution.desired()[0], kStart[0] + 0.004, 1e-12) << "half of the offset after half of the hold";
  EXPECT_EQ(execution.progress(), 0.0);
  for (int i = 100; i < 200; ++i)
    execution.tick(true);
  EXPECT_LT(apart(execution.desired(), kStart), 1e-12);
}

TEST(PathExecution, PassesTheWaypointsAtTheirTimes) {
  PathExecution execution(configuration());
  execution.start(plan(), kStart);
  for (int i = 0; i < 200 + 500; ++i)
    execution.tick(true);
  EXPECT_LT(apart(execution.desired(), kMiddle), 1e-9);
  EXPECT_NEAR(execution.progress(), 0.5 / 1.3, 1e-9);
  for (int i = 0; i < 400; ++i)  // half of the second edge's time: a quintic is then halfway
    execution.tick(true);
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_NEAR(execution.desired()[j], 0.5 * (kMiddle[j] + kGoal[j]), 1e-9);
}

TEST(PathExecution, EndsAtTheGoalAndStaysThere) {
  PathExecution execution(configuration());
  execution.start(plan(), kStart);
  EXPECT_NEAR(ticksOf(&execution), 1500, 1);
  EXPECT_EQ(execution.progress(), 1.0);
  EXPECT_EQ(execution.rested(), 0.0);
  for (int i = 0; i < 50; ++i)
    EXPECT_LT(apart(execution.tick(true).q, kGoal), 1e-12);
  EXPECT_NEAR(execution.rested(), 0.050, 1e-12);
  EXPECT_EQ(execution.goal(), kGoal);
}

TEST(PathExecution, AtHalfTheSpeedTakesThePathTwiceAsLong) {
  PathExecution execution(configuration(0.5));
  execution.start(plan(), kStart);
  EXPECT_NEAR(ticksOf(&execution), 200 + 2600, 1);
}

TEST(PathExecution, StandsStillAsLongAsTheArmMayNotMove) {
  PathExecution execution(configuration()), undisturbed(configuration());
  execution.start(plan(), kStart);
  undisturbed.start(plan(), kStart);
  for (int i = 0; i < 400; ++i) {
    execution.tick(true);
    undisturbed.tick(true);
  }
  const JointArray stood = execution.desired();
  for (int i = 0; i < 77; ++i)
    EXPECT_EQ(execution.tick(false).q, stood);
  EXPECT_EQ(execution.tick(false).dq, JointArray{}) << "at rest";
  EXPECT_NEAR(execution.waited(), 0.078, 1e-12);
  for (int i = 0; i < 300; ++i)
    execution.tick(true);
  // 1 + 2 + ... + 100 hundredths of a tick in the first hundred of them: 50.5, then whole ones.
  EXPECT_NEAR(execution.progress(), (400 - 200 + 50.5 + 200) / 1300.0, 1e-12) << "it resumes where it stopped";
  EXPECT_EQ(execution.waited(), 0.0);
}

TEST(PathExecution, ComesUpToSpeedAgainAfterAWait) {
  // GIVEN a path that has to wait where it is fastest, at the middle of its first edge
  PathExecution execution(configuration());
  execution.start(plan(), kStart);
  for (int i = 0; i < 200 + 250; ++i)
    execution.tick(true);
  const JointArray fastest = execution.tick(true).dq;
  for (int i = 0; i < 30; ++i)
    execution.tick(false);
  // WHEN it resumes THEN no joint's rate jumps by more than a hundredth of the highest rate in a tick. The path's
  // acceleration is added: at most 10/sqrt(3) of the distance over the square of the time
  JointArray before{};
  for (int i = 0; i < 100; ++i) {
    const JointArray now = execution.tick(true).dq;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double own = 10.0 / std::sqrt(3.0) * std::abs(kMiddle[j] - kStart[j]) / 0.25 * 1e-3;
      EXPECT_LE(std::abs(now[j] - before[j]), 0.0101 * std::abs(fastest[j]) + own);
    }
    before = now;
  }
}

TEST(PathExecution, NeverJumps) {
  PathExecution execution(configuration());
  JointArray from = kStart;
  from[1] += 0.01;
  execution.start(plan(), from);
  JointArray before = from;
  for (int i = 0; i < 1600; ++i) {
    const JointTarget target = execution.tick(true);
    const JointArray now = target.q;
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_NEAR(now[j] - before[j], target.dq[j] * 1e-3, 1e-15) << "the rate is that of this tick";
    // Peak rate of a quintic: 15/8 of the mean, here 0.2 rad in 0.5 s; of the hold 0.01 rad in 0.2 s.
    EXPECT_LT(apart(now, before), (0.2 / 0.5 + 0.01 / 0.2) * 15.0 / 8.0 * 1e-3);
    before = now;
  }
}

TEST(PathExecution, AnotherStartIsAsTheFirst) {
  // GIVEN executions abandoned at any time, the last one after its end, and while they wait
  for (const int ticks : {1, 150, 450, 900, 1600}) {
    PathExecution used(configuration()), fresh(configuration());
    used.start(plan(), kMiddle);
    for (int i = 0; i < ticks; ++i)
      used.tick(true);
    for (int i = 0; i < 7; ++i)
      used.tick(false);
    used.start(plan(), kGoal);
    fresh.start(plan(), kGoal);
    for (int i = 0; i < 1600; ++i) {
      ASSERT_EQ(used.desired(), fresh.desired()) << ticks << ", tick " << i;
      ASSERT_EQ(used.progress(), fresh.progress());
      ASSERT_EQ(used.waited(), fresh.waited());
      ASSERT_EQ(used.rested(), fresh.rested());
      ASSERT_EQ(used.tick(true).dq, fresh.tick(true).dq) << ticks << ", tick " << i;
    }
  }
}

TEST(PathExecution, OfMoreWaypointsThanThereCanBeEndsAtTheLastThatThereIs) {
  PlanResult endless = plan();
  endless.waypoint_count = kMaxWaypoints + 1;
  endless.waypoints.back() = kGoal;
  endless.arrival.back() = 0.7;
  endless.cost = 99.0;  // lies behind the arrivals in memory
  PathExecution execution(configuration());
  execution.start(endless, kStart);
  EXPECT_EQ(execution.duration(), 0.7);
  EXPECT_EQ(execution.goal(), kGoal);
}

TEST(PathExecution, OfOneWaypointIsOverAfterTheHold) {
  PlanResult single = plan();
  single.waypoint_count = 1;
  PathExecution execution(configuration());
  execution.start(single, kStart);
  EXPECT_NEAR(ticksOf(&execution), 200, 1);
  EXPECT_EQ(execution.progress(), 1.0);
  EXPECT_LT(apart(execution.desired(), kStart), 1e-12);
}

}  // namespace
}  // namespace raven2_trainer::control
