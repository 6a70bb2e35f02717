#include "raven2_trainer/physics/arm_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// One arm alone against the same arm in the world of both.

namespace raven2_trainer::physics {
namespace {

using testing::makeEmptyScene;
using testing::makeRaven;

constexpr int kTicks = 1500;

/** All terms of the dynamics: dry friction on three joints, as the robot has it, viscous friction on all. */
ModelConfig everyTerm(int sub_steps) {
  ModelConfig config = testing::modelConfig();
  config.sub_steps = sub_steps;
  config.coulomb_friction = {0.464, 0.847, 9.0, 0.0, 0.0, 0.0, 0.0};
  config.viscous_friction = {3.74, 2.93, 1080.0, 0.0096, 0.0394, 0.0394, 0.0394};
  return config;
}

/** Jumps about home five times a second, the jaws as far as against each other. */
class JumpingTarget {
 public:
  JumpingTarget(const JointArray& home, std::uint64_t seed) : home_(home), random_(seed) {}

  const JointArray& at(int tick) {
    if (tick % 200 != 0) return target_;
    constexpr JointArray kRange{0.2, 0.2, 0.03, 1.0, 0.5, 0.0, 0.0};
    for (std::size_t j = 0; j < kJointCount; ++j)
      target_[j] = home_[j] + random_.uniform(-kRange[j], kRange[j]);
    target_[kGrasp1] = random_.uniform(-0.3, 0.8);
    target_[kGrasp2] = random_.uniform(-0.3, 0.8);
    return target_;
  }

 private:
  JointArray home_;
  JointArray target_{};
  Random random_;
};

JointArray drive(const ArmWorld& world, const JointArray& target) {
  JointArray tau = world.gravityTorque();
  for (std::size_t j = 0; j < kJointCount; ++j)
    tau[j] += testing::kStiffness[j] * (target[j] - world.q()[j]) - testing::kDamping[j] * world.dq()[j];
  return tau;
}

struct Trace {
  std::vector<JointArray> q, dq;
  bool operator==(const Trace& other) const { return q == other.q && dq == other.dq; }
};

Trace run(const model::RavenModel& raven, Arm arm, std::uint64_t seed, int sub_steps) {
  attachOdeToThread();
  ArmWorld world(raven, arm, everyTerm(sub_steps));
  JumpingTarget target(raven.arms.geometry.home, seed);
  Trace trace;
  for (int tick = 0; tick < kTicks; ++tick) {
    world.step(drive(world, target.at(tick)));
    trace.q.push_back(world.q());
    trace.dq.push_back(world.dq());
  }
  return trace;
}

/** The same in the world of both arms; the other one holds still. */
Trace runWithBoth(const model::RavenModel& raven, Arm arm, std::uint64_t seed, int sub_steps, double* least_opening) {
  RavenWorld world(raven, makeEmptyScene(), everyTerm(sub_steps));
  JumpingTarget target(raven.arms.geometry.home, seed);
  PerArm<JointArray> targets{raven.arms.geometry.home, raven.arms.geometry.home};
  Trace trace;
  for (int tick = 0; tick < kTicks; ++tick) {
    at(targets, arm) = target.at(tick);
    testing::driveStep(&world, targets);
    EXPECT_EQ(world.contacts(arm), 0U) << "or nothing can be compared";
    trace.q.push_back(testing::position(world, arm));
    trace.dq.push_back(testing::rate(world, arm));
    *least_opening = std::min(*least_opening, trace.q.back()[kGrasp1] + trace.q.back()[kGrasp2]);
  }
  return trace;
}

/** Largest difference of two traces. */
double difference(const std::vector<JointArray>& a, const std::vector<JointArray>& b) {
  double worst = a.size() == b.size() ? 0.0 : 1.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      worst = std::max(worst, std::abs(a[i][j] - b[i][j]));
  }
  return worst;
}

// It solves the same equations with fewer rows: what is left is rounding, and kHeavy of arm_bodies.cpp.
TEST(ArmWorld, MovesAsItsArmInTheWorldOfBoth) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  for (const Arm arm : kArms) {
    for (const int sub_steps : {1, 4}) {
      double least_opening = 1.0;
      const Trace both = runWithBoth(raven, arm, 5, sub_steps, &least_opening);
      const Trace alone = run(raven, arm, 5, sub_steps);
      EXPECT_LT(difference(alone.q, both.q), 1e-9) << name(arm) << " " << sub_steps;
      EXPECT_LT(difference(alone.dq, both.dq), 1e-7) << name(arm) << " " << sub_steps;
      EXPECT_LT(least_opening, 0.01) << "the jaws must have met";
    }
  }
}

TEST(ArmWorld, TwoInTwoThreadsMoveAsOneAlone) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  const Trace gold = run(raven, Arm::kGold, 7, 1), green = run(raven, Arm::kGreen, 8, 1);
  EXPECT_FALSE(gold == green) << "the comparison must notice a difference";
  // Several rounds: without a separate threading implementation for each world, ODE aborts in most of them.
  for (int round = 0; round < 4; ++round) {
    Trace other;
    std::thread thread([&] { other = run(raven, Arm::kGreen, 8, 1); });
    EXPECT_TRUE(run(raven, Arm::kGold, 7, 1) == gold);
    thread.join();
    EXPECT_TRUE(other == green);
  }
}

TEST(ArmWorld, GoesOnFromAKeptMotionWithTheSameBits) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  ArmWorld first(raven, Arm::kGold, everyTerm(1)), second(raven, Arm::kGold, everyTerm(1));
  JumpingTarget target(raven.arms.geometry.home, 3);
  for (int tick = 0; tick < 700; ++tick)
    first.step(drive(first, target.at(tick)));
  const ArmMotion kept = first.motion();
  second.setState(raven.arms.geometry.home, {1.0, -1.0, 0.1, 1.0, 1.0, 1.0, 1.0});
  for (int tick = 0; tick < 50; ++tick)
    second.step(drive(second, raven.arms.geometry.home));
  second.restore(kept);
  for (int tick = 700; tick < 1400; ++tick) {
    const JointArray q_d = target.at(tick);
    first.step(drive(first, q_d));
    second.step(drive(second, q_d));
    ASSERT_EQ(first.q(), second.q()) << tick;
    ASSERT_EQ(first.dq(), second.dq()) << tick;
  }
}

TEST(ArmWorld, SetStateForgetsThePast) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  const JointArray home = raven.arms.geometry.home, dq{0.5, -0.5, 0.05, 1.0, 0.5, 0.5, -0.5};
  ArmWorld used(raven, Arm::kGreen, everyTerm(1)), fresh(raven, Arm::kGreen, everyTerm(1));
  JumpingTarget target(home, 4);
  for (int tick = 0; tick < 500; ++tick)
    used.step(drive(used, target.at(tick)));
  used.setState(home, dq);
  fresh.setState(home, dq);
  for (int tick = 0; tick < 300; ++tick) {
    used.step(drive(used, home));
    fresh.step(drive(fresh, home));
  }
  EXPECT_EQ(used.q(), fresh.q());
  EXPECT_EQ(used.dq(), fresh.dq());
}

TEST(ArmWorld, WhatIsNotFiniteFreezesItUntilItIsPutRight) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  const JointArray home = raven.arms.geometry.home;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ArmWorld world(raven, Arm::kGold, everyTerm(1));
    JointArray tau = world.gravityTorque(), q = home;
    tau[kElbow] = bad;
    q[kWrist] = bad;
    world.step(tau);
    EXPECT_FALSE(world.healthy());
    world.step(JointArray{});
    EXPECT_EQ(world.q(), home);
    world.setState(home, JointArray{});
    EXPECT_TRUE(world.healthy());
    world.setState(q, JointArray{});
    EXPECT_FALSE(world.healthy());
    EXPECT_EQ(world.q(), home);
  }
}

TEST(ArmWorld, AnExplodingStepDoesNotEndTheProcess) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  for (const double huge : {1e30, 1e200, 1e300}) {
    ArmWorld world(raven, Arm::kGold, everyTerm(1));
    JointArray tau;
    tau.fill(huge);
    for (int tick = 0; tick < 50; ++tick)
      world.step(tau);
    EXPECT_FALSE(world.healthy()) << huge;
    for (const double q : world.q())
      EXPECT_TRUE(std::isfinite(q)) << huge;
  }
}

}  // namespace
}  // namespace raven2_trainer::physics
