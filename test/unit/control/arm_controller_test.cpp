#include "raven2_trainer/control/arm_controller.h"

#include <gtest/gtest.h>

namespace raven2_trainer::control {
namespace {

ControllerConfig config() {
  ControllerConfig c;
  c.gravity_compensation = true;
  c.gains.fill({100.0, 2.0, 0.0, 50.0});
  c.gains[kInsertion].ki = 40.0;
  c.gains[kWrist].kp = 0.0;
  c.green_insertion_kd = 3.0;
  c.viscous_friction.fill(0.5);
  return c;
}

JointArray only(Joint joint, double value) {
  JointArray values{};
  values[joint] = value;
  return values;
}

TEST(ArmController, AddsGravityToThePd) {
  ArmController controller(config(), Arm::kGold);
  const JointArray tau = controller.torque(only(kElbow, 0.3), only(kElbow, 0.1), only(kElbow, 4.0), only(kElbow, 1.25));
  EXPECT_DOUBLE_EQ(tau[kElbow], 100 * (0.3 - 0.1) - 2 * 4.0 + 1.25);
}

TEST(ArmController, LeavesGravityAloneWhereTheConfigurationSaysSo) {
  ControllerConfig bare = config();
  bare.gravity_compensation = false;
  ArmController controller(bare, Arm::kGold);
  EXPECT_EQ(controller.torque({}, {}, {}, only(kElbow, 1.25)), JointArray{});
}

TEST(ArmController, TheGreenInsertionHasItsOwnDamping) {
  const JointArray dq = only(kInsertion, 0.7);
  ArmController gold(config(), Arm::kGold), green(config(), Arm::kGreen);
  EXPECT_DOUBLE_EQ(gold.torque({}, {}, dq, {})[kInsertion], -2.0 * 0.7);
  EXPECT_DOUBLE_EQ(green.torque({}, {}, dq, {})[kInsertion], -3.0 * 0.7);
}

TEST(ArmController, LeadsByTheDampingAndFrictionOverTheStiffness) {
  JointTarget target;
  target.q.fill(0.2);
  target.dq.fill(0.4);
  const JointArray gold = ArmController(config(), Arm::kGold).leading(target);
  EXPECT_DOUBLE_EQ(gold[kShoulder], 0.2 + (2.0 + 0.5) / 100 * 0.4);
  EXPECT_DOUBLE_EQ(gold[kGrasp2], 0.2 + (2.0 + 0.5) / 100 * 0.4);
  EXPECT_DOUBLE_EQ(gold[kWrist], 0.2) << "without stiffness nothing leads";
  EXPECT_DOUBLE_EQ(ArmController(config(), Arm::kGreen).leading(target)[kInsertion], 0.2 + (3.0 + 0.5) / 100 * 0.4);
}

TEST(ArmController, AskedForWhatLeadsItBalancesFrictionOnTheTarget) {
  // GIVEN an arm exactly on a target in motion, THEN the torque is what viscous friction takes, and gravity
  JointTarget target;
  target.q.fill(0.2);
  target.dq.fill(0.4);
  target.dq[kWrist] = 0.0;
  ArmController controller(config(), Arm::kGreen);
  const JointArray tau = controller.torque(controller.leading(target), target.q, target.dq, only(kShoulder, 1.5));
  EXPECT_NEAR(tau[kShoulder], 0.5 * 0.4 + 1.5, 1e-12);
  EXPECT_NEAR(tau[kToolRotation], 0.5 * 0.4, 1e-12);
}

TEST(ArmController, ResetForgetsTheIntegral) {
  ArmController controller(config(), Arm::kGold);
  const JointArray q_d = only(kInsertion, 0.1);
  const JointArray first = controller.torque(q_d, {}, {}, {});
  EXPECT_GT(controller.torque(q_d, {}, {}, {})[kInsertion], first[kInsertion]);
  controller.reset();
  EXPECT_EQ(controller.torque(q_d, {}, {}, {}), first);
}

}  // namespace
}  // namespace raven2_trainer::control
