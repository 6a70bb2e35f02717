#include "raven2_trainer/control/path_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raven2_trainer::control {
namespace {

constexpr JointArray kVelocityLimit{0.5, 0.5, 0.1, 2.0, 2.0, 2.0, 2.0};
constexpr JointArray kAccelerationLimit{2.0, 2.0, 0.5, 10.0, 10.0, 10.0, 10.0};

/** Largest speed and acceleration of a motion, as fractions of the limits, by finite differences of quinticBlend. */
struct Peaks {
  double velocity{}, acceleration{};
};

Peaks samplePeaks(const JointArray& delta, double duration) {
  constexpr int kSamples = 20000;
  const double h = 1.0 / kSamples;
  Peaks peaks;
  for (int i = 1; i < kSamples; ++i) {
    const double before = quinticBlend((i - 1) * h), now = quinticBlend(i * h), after = quinticBlend((i + 1) * h);
    const double speed = std::abs(after - before) / (2 * h * duration);
    const double acceleration = std::abs(after - 2 * now + before) / (h * h * duration * duration);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      peaks.velocity = std::max(peaks.velocity, std::abs(delta[j]) * speed / kVelocityLimit[j]);
      peaks.acceleration = std::max(peaks.acceleration, std::abs(delta[j]) * acceleration / kAccelerationLimit[j]);
    }
  }
  return peaks;
}

PlanResult threeWaypoints() {
  PlanResult plan;
  plan.status = PlanStatus::kSuccess;
  plan.waypoint_count = 3;
  plan.waypoints[0] = {0.1, 1.0, 0.40, 0.0, 0.0, 0.2, 0.2};
  plan.waypoints[1] = {0.3, 0.9, 0.42, 0.5, 0.0, 0.1, 0.3};
  plan.waypoints[2] = {0.2, 1.2, 0.35, -0.5, 0.4, 0.2, 0.2};
  plan.arrival[1] = 0.250;
  plan.arrival[2] = 0.700;
  return plan;
}

void expectNear(const JointArray& a, const JointArray& b, double tolerance) {
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_NEAR(a[j], b[j], tolerance) << kJointNames[j];
}

TEST(QuinticDuration, KeepsBothLimitsAndReachesOne) {
  // GIVEN long, short, and one-joint motions: the first is bound by speed, the others by acceleration
  const std::array<JointArray, 4> deltas{
      JointArray{1.0, -0.2, 0.05, 0.3, 0.0, 0.0, 0.0}, JointArray{0.01, 0.02, 0.001, 0.0, 0.0, 0.0, 0.0},
      JointArray{0.0, 0.0, -0.2, 0.0, 0.0, 0.0, 0.0}, JointArray{0.0, 0.0, 0.0, 0.0, 0.1, -0.4, 0.4}};
  for (const JointArray& delta : deltas) {
    const Peaks peaks = samplePeaks(delta, quinticDuration(delta, kVelocityLimit, kAccelerationLimit));
    // THEN nothing is exceeded and the slower of the two limits is met (1e-6: the finite differences)
    EXPECT_LE(peaks.velocity, 1.0 + 1e-6);
    EXPECT_LE(peaks.acceleration, 1.0 + 1e-6);
    EXPECT_NEAR(std::max(peaks.velocity, peaks.acceleration), 1.0, 1e-6);
  }
}

TEST(QuinticDuration, IsZeroForNoMotion) {
  EXPECT_EQ(quinticDuration({}, kVelocityLimit, kAccelerationLimit), 0.0);
}

TEST(QuinticBlend, RestsAtBothEndsAndIsClamped) {
  EXPECT_EQ(quinticBlend(0.0), 0.0);
  EXPECT_EQ(quinticBlend(1.0), 1.0);
  EXPECT_DOUBLE_EQ(quinticBlend(0.5), 0.5);
  EXPECT_EQ(quinticBlend(-3.0), 0.0);
  EXPECT_EQ(quinticBlend(7.0), 1.0);
  // Zero velocity and acceleration at the ends leave only the cubic term, 10 s^3.
  EXPECT_NEAR(quinticBlend(1e-3), 1e-8, 2e-11);
  EXPECT_NEAR(1.0 - quinticBlend(1.0 - 1e-3), 1e-8, 2e-11);
}

TEST(PathFollower, PassesEveryWaypointAtItsTimeAndEnds) {
  const PlanResult plan = threeWaypoints();
  PathFollower follower;
  follower.start(plan);
  ASSERT_TRUE(follower.active());
  for (int tick = 1; tick <= 700; ++tick) {
    const JointArray q = follower.tick();
    if (tick == 250) expectNear(q, plan.waypoints[1], 1e-12);
    EXPECT_EQ(follower.active(), tick < 700) << tick;
    if (tick == 700) expectNear(q, plan.waypoints[2], 0.0);
  }
  // THEN it stays there
  EXPECT_EQ(follower.tick(), plan.waypoints[2]);
  EXPECT_FALSE(follower.active());
}

TEST(PathFollower, StartsAndStopsAtRestAtEveryWaypoint) {
  const PlanResult plan = threeWaypoints();
  PathFollower follower;
  follower.start(plan);
  JointArray before = plan.waypoints[0];
  for (int tick = 1; tick <= 700; ++tick) {
    const JointArray q = follower.tick();
    const bool at_rest = tick == 1 || tick == 250 || tick == 251 || tick == 700;
    // 10 (1/250)^3 of the distance, at most 1 rad, in the first and last tick of a segment
    if (at_rest) expectNear(q, before, 1e-6);
    before = q;
  }
}

TEST(PathFollower, MovesOnAStraightLineBetweenWaypoints) {
  const PlanResult plan = threeWaypoints();
  PathFollower follower;
  follower.start(plan);
  for (int tick = 1; tick < 250; ++tick) {
    const JointArray q = follower.tick();
    const double s = (q[kShoulder] - 0.1) / 0.2;
    EXPECT_NEAR(q[kToolRotation], 0.5 * s, 1e-12);
    EXPECT_NEAR(q[kInsertion], 0.40 + 0.02 * s, 1e-12);
  }
}

TEST(QuinticTarget, MovesAsFastAsItsPositionSays) {
  const JointArray from{0.1, 1.0, 0.40, 0.0, 0.0, 0.2, 0.2}, to{0.3, 0.9, 0.42, 0.5, 0.0, 0.1, 0.3};
  constexpr double kStep = 1e-5;
  for (double t = 0.3; t < 1.2; t += 0.05) {
    const JointTarget before = quinticTarget(from, to, 0.5, 1.0, t - kStep);
    const JointTarget now = quinticTarget(from, to, 0.5, 1.0, t), after = quinticTarget(from, to, 0.5, 1.0, t + kStep);
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_NEAR(now.dq[j], (after.q[j] - before.q[j]) / (2 * kStep), 1e-7) << t << " " << kJointNames[j];
  }
}

TEST(QuinticTarget, RestsBeforeAndAfter) {
  const JointArray from{0.1}, to{0.3};
  EXPECT_EQ(quinticTarget(from, to, 0.5, 1.0, 0.2).q, from);
  EXPECT_EQ(quinticTarget(from, to, 0.5, 1.0, 0.2).dq, JointArray{});
  expectNear(quinticTarget(from, to, 0.5, 1.0, 1.7).q, to, 1e-15);
  EXPECT_EQ(quinticTarget(from, to, 0.5, 1.0, 1.7).dq, JointArray{});
  EXPECT_EQ(quinticTarget(from, to, 0.5, 0.5, 0.5).dq, JointArray{}) << "no duration is no jump of the rate";
}

TEST(PathFollower, TellsHowFastItsTargetMoves) {
  PathFollower follower;
  follower.start(threeWaypoints());
  JointArray before = follower.tick(), now = follower.tick();
  for (int tick = 2; tick < 699; ++tick) {
    const JointTarget target = follower.target();
    EXPECT_EQ(target.q, now);
    const JointArray after = follower.tick();
    for (std::size_t j = 0; j < kJointCount; ++j)  // the central difference misses a sixth of the third derivative
      EXPECT_NEAR(target.dq[j], (after[j] - before[j]) / (2 * kTickSeconds), 1e-3) << tick;
    before = now;
    now = after;
  }
  follower.stop();
  EXPECT_EQ(follower.target().q, now);
  EXPECT_EQ(follower.target().dq, JointArray{});
}

TEST(PathFollower, HoldsWhereItWasStopped) {
  PathFollower follower;
  follower.start(threeWaypoints());
  JointArray q{};
  for (int tick = 0; tick < 100; ++tick)
    q = follower.tick();
  follower.stop();
  EXPECT_FALSE(follower.active());
  EXPECT_EQ(follower.tick(), q);
}

TEST(PathFollower, BeginsAnewWithEveryPlan) {
  PathFollower follower;
  follower.start(threeWaypoints());
  for (int tick = 0; tick < 400; ++tick)
    follower.tick();
  const PlanResult plan = threeWaypoints();
  follower.start(plan);
  expectNear(follower.tick(), plan.waypoints[0], 1e-6);
}

TEST(PathFollower, RefusesAPlanThatFailedOrIsTooLong) {
  PathFollower follower;
  PlanResult plan = threeWaypoints();
  plan.status = PlanStatus::kNoPath;
  follower.start(plan);
  EXPECT_FALSE(follower.active());
  plan = threeWaypoints();
  plan.waypoint_count = kMaxWaypoints + 1;
  follower.start(plan);
  EXPECT_FALSE(follower.active());
  follower.tick();
  plan.waypoint_count = 0;
  follower.start(plan);
  EXPECT_FALSE(follower.active());
}

TEST(PathFollower, EndsAtOnceOnASingleWaypoint) {
  PlanResult plan = threeWaypoints();
  plan.waypoint_count = 1;
  PathFollower follower;
  follower.start(plan);
  EXPECT_EQ(follower.tick(), plan.waypoints[0]);
  EXPECT_FALSE(follower.active());
}

TEST(PathFollower, SkipsAnEdgeOfNoLength) {
  PlanResult plan = threeWaypoints();
  plan.waypoints[1] = plan.waypoints[0];
  plan.arrival[1] = 0.0;
  PathFollower follower;
  follower.start(plan);
  for (int tick = 1; tick <= 700; ++tick) {
    for (const double q : follower.tick())
      ASSERT_TRUE(std::isfinite(q));
  }
  EXPECT_EQ(follower.tick(), plan.waypoints[2]);
}

}  // namespace
}  // namespace raven2_trainer::control
