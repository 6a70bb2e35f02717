#include "raven2_trainer/loop/model_driver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

struct Drive {
  explicit Drive(const TrainerConfig& config)
      : raven(model::loadRavenModel(config)),
        world(raven, model::loadSceneModel(config), config.model),
        driver(config.model, config.arms.geometry, &world),
        home(config.arms.geometry.home) {
    for (const Arm arm : kArms) {
      world.setCollisions(arm, false);
      world.setJointState(arm, home, JointArray{});
    }
  }
  JointArray q(Arm arm) const {
    JointArray q, dq;
    world.jointState(arm, &q, &dq);
    return q;
  }

  model::RavenModel raven;
  physics::RavenWorld world;
  ModelDriver driver;
  JointArray home;
};

TEST(ModelDriver, AtItsTargetOnlyGravityIsCompensated) {
  raven2_trainer::testing::useOde();
  Drive drive(raven2_trainer::testing::packagedConfig());
  const JointArray held = drive.world.gravityTorque(Arm::kGold);
  const PerArm<JointArray> tau = drive.driver.step({drive.home, drive.home});
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_NEAR(at(tau, Arm::kGold)[j], held[j], 1e-6) << kJointNames[j];
  EXPECT_GT(std::abs(held[kElbow]), 0.1) << "[Nm] gravity must be large enough to be seen";
}

/** Gold's joints after a second with a goal 0.01 beyond home. At half a second the insertion is moved by `aside`. */
JointArray afterASecond(bool open_loop, double aside) {
  const TrainerConfig config = raven2_trainer::testing::packagedConfig();
  Drive drive(config);
  drive.driver.allowOpenLoop(drive.raven, config.model);
  if (open_loop) drive.driver.openLoop(Arm::kGold);
  JointArray goal = drive.home;
  for (double& q : goal)
    q += 0.01;
  for (int i = 0; i < 1000; ++i) {
    if (i == 500) {
      JointArray q, dq;
      drive.world.jointState(Arm::kGold, &q, &dq);
      q[kInsertion] += aside;
      drive.world.setJointState(Arm::kGold, q, dq);
    }
    drive.driver.step({goal, drive.home});
  }
  return drive.q(Arm::kGold);
}

TEST(ModelDriver, InOpenLoopAnArmGoesWhereItsLawWouldTakeItButIsNotBroughtBack) {
  raven2_trainer::testing::useOde();
  const JointArray closed = afterASecond(false, 0.0), open = afterASecond(true, 0.0);
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_NEAR(open[j], closed[j], 1e-6) << kJointNames[j];
  EXPECT_NEAR(afterASecond(false, 0.002)[kInsertion], closed[kInsertion], 0.0005)
      << "the control law brings the joint back";
  EXPECT_NEAR(afterASecond(true, 0.002)[kInsertion], closed[kInsertion] + 0.002, 0.0005);
}

TEST(ModelDriver, AResetClosesTheLoopOfItsArm) {
  raven2_trainer::testing::useOde();
  const TrainerConfig config = raven2_trainer::testing::packagedConfig();
  for (const Arm closed : kArms) {
    Drive drive(config);
    drive.driver.allowOpenLoop(drive.raven, config.model);
    for (const Arm arm : kArms)
      drive.driver.openLoop(arm);
    drive.driver.reset(closed);
    JointArray aside = drive.home;
    aside[kElbow] += 0.02;
    for (const Arm arm : kArms)
      drive.world.setJointState(arm, aside, JointArray{});
    for (int i = 0; i < 1000; ++i)
      drive.driver.step({drive.home, drive.home});
    EXPECT_NEAR(drive.q(closed)[kElbow], drive.home[kElbow], 0.005) << name(closed);
    EXPECT_GT(drive.q(otherArm(closed))[kElbow], drive.home[kElbow] + 0.01)
        << name(closed) << ": the other arm stays displaced";
  }
}

TEST(ModelDriver, AResetEndsTheForcesOnItsArm) {
  raven2_trainer::testing::useOde();
  Effort push;
  push.kind = EffortKind::kJoints;
  push.numbers[kElbow] = 1.0;
  for (const Arm arm : kArms) {
    Drive drive(raven2_trainer::testing::packagedConfig());
    for (const Arm each : kArms)
      drive.driver.push(each, push);
    drive.driver.reset(arm);
    EXPECT_FALSE(drive.driver.isPushed(arm)) << name(arm);
    EXPECT_TRUE(drive.driver.isPushed(otherArm(arm))) << name(arm) << ": the other arm is still pushed";
    const double held = drive.world.gravityTorque(arm)[kElbow];
    const PerArm<JointArray> tau = drive.driver.step({drive.home, drive.home});
    EXPECT_NEAR(at(tau, arm)[kElbow], held, 1e-6) << name(arm);
  }
}

TEST(ModelDriver, WithoutCompensationTheArmSags) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.model.coulomb_friction = {};
  Drive held(config);
  config.model.gravity_compensation = false;
  Drive sagging(config);
  for (int i = 0; i < 2000; ++i) {
    held.driver.step({held.home, held.home});
    sagging.driver.step({sagging.home, sagging.home});
  }
  EXPECT_NEAR(held.q(Arm::kGold)[kElbow], held.home[kElbow], 1e-7);
  const double load = sagging.world.gravityTorque(Arm::kGold)[kElbow];
  // The joint settles where its stiffness carries the load.
  EXPECT_NEAR(sagging.q(Arm::kGold)[kElbow] - sagging.home[kElbow], -load / config.model.gains[kElbow].kp, 1e-5);
}

TEST(ModelDriver, TheGreenInsertionHasItsOwnDamping) {
  // GIVEN both insertions moving at 10 mm/s at their targets, THEN the torques differ from gravity by kd v
  raven2_trainer::testing::useOde();
  const TrainerConfig config = raven2_trainer::testing::packagedConfig();
  Drive drive(config);
  JointArray rate{};
  rate[kInsertion] = 0.01;
  for (const Arm arm : kArms)
    drive.world.setJointState(arm, drive.home, rate);
  const double gold_load = drive.world.gravityTorque(Arm::kGold)[kInsertion];
  const double green_load = drive.world.gravityTorque(Arm::kGreen)[kInsertion];
  const PerArm<JointArray> tau = drive.driver.step({drive.home, drive.home});
  EXPECT_NEAR(gold_load - at(tau, Arm::kGold)[kInsertion], 0.01 * config.model.gains[kInsertion].kd, 1e-6);
  EXPECT_NEAR(green_load - at(tau, Arm::kGreen)[kInsertion], 0.01 * config.model.green_insertion_kd, 1e-6);
}

}  // namespace
}  // namespace raven2_trainer::loop
