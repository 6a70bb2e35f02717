#include "raven2_trainer/runtime/model_driver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/rig.h"

namespace raven2_trainer::runtime {
namespace {

struct Drive {
  explicit Drive(const TrainerConfig& config)
      : raven(model::loadRavenModel(config)),
        world(raven, model::loadSceneModel(config), config.model),
        driver(config.model, &world),
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
  EXPECT_GT(std::abs(held[kElbow]), 0.1) << "[Nm] or the test could not tell";
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
  // the joint settles where the stiffness carries the load
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
}  // namespace raven2_trainer::runtime
