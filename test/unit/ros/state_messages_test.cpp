#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "ros/bridge/messages.h"
#include "ros/bridge/state_topics.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kD4 = -0.47;  // [m] raven2.md 2.1
const ros::Time kStamp(30, 7);

/** Joint values that differ from joint to joint and from arm to arm. */
JointArray numbers(Arm arm, double first) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = first + 0.1 * static_cast<double>(j) + 10.0 * static_cast<double>(index(arm));
  return q;
}

/** raven2.md 5.4: the wrist of the right arm and grasper 2 are negated; rates and torques have no offset. */
std::vector<double> signedNumbers(double first) {
  std::vector<double> expected;
  for (const Arm arm : kArms) {
    JointArray q = numbers(arm, first);
    if (arm == Arm::kGreen) q[kWrist] = -q[kWrist];
    q[kGrasp2] = -q[kGrasp2];
    expected.insert(expected.end(), q.begin(), q.end());
  }
  return expected;
}

void expectNear(const std::vector<double>& values, const std::vector<double>& expected) {
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(values[i], expected[i], 1e-12) << i;
}

std::vector<double> positions(double first) {
  std::vector<double> expected = signedNumbers(first);
  for (const std::size_t arm : {0U, 7U}) {
    expected[arm + kInsertion] += kD4;
    expected[arm + kToolRotation] += (arm == 0 ? -1.0 : 1.0) * kPi / 4.0;
  }
  return expected;
}

const std::vector<std::string> kJoints{
    "shoulder_L",        "elbow_L",           "insertion_L", "tool_roll_L", "wrist_joint_L", "grasper_joint_1_L",
    "grasper_joint_2_L", "shoulder_R",        "elbow_R",     "insertion_R", "tool_roll_R",   "wrist_joint_R",
    "grasper_joint_1_R", "grasper_joint_2_R"};

TEST(JointStates, OfTheModelAreThoseOfBothArmsWithTheRobotsNamesAndSigns) {
  ModelState model;
  for (const Arm arm : kArms) {
    at(model.arms, arm).q = numbers(arm, 1.0);
    at(model.arms, arm).dq = numbers(arm, 2.0);
    at(model.arms, arm).tau = numbers(arm, 3.0);
  }
  const sensor_msgs::JointState message = jointState(model, kD4, kStamp);
  EXPECT_EQ(message.header.stamp, kStamp);
  EXPECT_EQ(message.name, kJoints);
  expectNear(message.position, positions(1.0));
  expectNear(message.velocity, signedNumbers(2.0));
  expectNear(message.effort, signedNumbers(3.0));
}

TEST(JointStates, OfTheRobotAreThoseOfBothArmsWithoutEffort) {
  RobotState robot;
  for (const Arm arm : kArms) {
    at(robot.arms, arm).q = numbers(arm, 1.0);
    at(robot.arms, arm).dq = numbers(arm, 2.0);
  }
  const sensor_msgs::JointState message = jointState(robot, kD4, kStamp);
  EXPECT_EQ(message.name, kJoints);
  expectNear(message.position, positions(1.0));
  expectNear(message.velocity, signedNumbers(2.0));
  EXPECT_TRUE(message.effort.empty()) << "the robot does not measure it";
}

TEST(ForceMessages, AreEachArmsForceInItsOwnBase) {
  HapticState haptic;
  haptic.force_B = {Vec3{1, -2, 3}, Vec3{-4, 5, -6}};
  haptic.force_I = {Vec3{9, 9, 9}, Vec3{9, 9, 9}};
  for (const Arm arm : kArms) {
    const geometry_msgs::WrenchStamped message = wrench(haptic, arm, kStamp);
    EXPECT_EQ(message.header.stamp, kStamp);
    EXPECT_EQ(message.header.frame_id, arm == Arm::kGold ? "model/base_link_L" : "model/base_link_R");
    const auto& f = message.wrench.force;
    EXPECT_EQ((Vec3{f.x, f.y, f.z}), at(haptic.force_B, arm)) << name(arm);
  }
}

TEST(Cycles, AreAtLeastOneHoweverSlowTheBridgeIs) {
  EXPECT_EQ(cyclesIn(0.033, 0.01), 3);
  EXPECT_EQ(cyclesIn(0.033, 0.001), 33);
  EXPECT_EQ(cyclesIn(0.033, 0.033), 1);
  EXPECT_EQ(cyclesIn(0.033, 1.0), 1) << "ros_period of runtime.yaml goes up to 1 s";
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
