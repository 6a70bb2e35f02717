#include "ros/crtk/crtk_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/** B 0.3 m along x of W, turned by 90 degrees about z: x of B is y of W. */
Pose placed() {
  Pose X_WB;
  X_WB.R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  X_WB.p = Vector3(0.3, 0.0, 0.0);
  return X_WB;
}

sensor_msgs::JointState jointsAt(const std::vector<double>& positions) {
  sensor_msgs::JointState message;
  message.position = positions;
  return message;
}

geometry_msgs::PoseStamped poseAt(double x, double y, double z, const std::string& frame = "") {
  geometry_msgs::PoseStamped message;
  message.header.frame_id = frame;
  message.pose.position.x = x;
  message.pose.position.y = y;
  message.pose.position.z = z;
  message.pose.orientation.w = 1.0;
  return message;
}

void expectVector(const Vec3& v, double x, double y, double z) {
  EXPECT_NEAR(v[0], x, 1e-12);
  EXPECT_NEAR(v[1], y, 1e-12);
  EXPECT_NEAR(v[2], z, 1e-12);
}

/** Expects the same rotation; q and -q are equal. */
void expectTurn(const Quat& q, double x, double y, double z, double w) {
  EXPECT_NEAR(std::abs(q[0] * x + q[1] * y + q[2] * z + q[3] * w), 1.0, 1e-12)
      << q[0] << ' ' << q[1] << ' ' << q[2] << ' ' << q[3];
}

const double kHalf = std::sqrt(0.5);

TEST(CrtkReader, EveryStateCommandByItsWordAndNoOther) {
  const std::vector<std::string> words{"enable", "disable", "pause", "resume", "home", "unhome"};
  for (std::size_t i = 0; i < words.size(); ++i) {
    const CrtkAsked asked = readState(Arm::kGreen, words[i]);
    ASSERT_TRUE(asked.command) << words[i];
    EXPECT_EQ(asked.command->kind, ServoKind::kState);
    EXPECT_EQ(asked.command->state, static_cast<StateCommand>(i));
    EXPECT_EQ(asked.command->arm, Arm::kGreen);
  }
  for (const std::string word : {"", "Enable", "enabled", "go"}) {
    const CrtkAsked asked = readState(Arm::kGold, word);
    EXPECT_FALSE(asked.command) << word;
    EXPECT_NE(asked.refusal.find("\"" + word + "\""), std::string::npos) << asked.refusal;
    EXPECT_NE(asked.refusal.find("resume"), std::string::npos) << "the message lists the valid words";
  }
}

TEST(CrtkReader, JointsAreTakenAsTheyStand) {
  const auto asked = readJoints(Arm::kGold, ServoKind::kMoveJoints, jointsAt({0.1, 1.2, -0.1, 0.4, 0.5, 0.6}));
  ASSERT_TRUE(asked.command);
  EXPECT_EQ(asked.command->kind, ServoKind::kMoveJoints);
  EXPECT_EQ(asked.command->joints, (ServoJoints{0.1, 1.2, -0.1, 0.4, 0.5, 0.6}));
  const auto jaw = readJaw(Arm::kGold, ServoKind::kServoJawBy, jointsAt({-0.25}));
  ASSERT_TRUE(jaw.command);
  EXPECT_EQ(jaw.command->kind, ServoKind::kServoJawBy);
  EXPECT_EQ(jaw.command->jaw, -0.25);
}

TEST(CrtkReader, TheWrongNumberOfJointsIsSaid) {
  for (const std::size_t n : {0U, 1U, 5U, 7U}) {
    const auto asked = readJoints(Arm::kGold, ServoKind::kServoJoints, jointsAt(std::vector<double>(n, 0.1)));
    EXPECT_FALSE(asked.command) << n;
    EXPECT_NE(asked.refusal.find("servo_jp: " + std::to_string(n) + " positions"), std::string::npos) << asked.refusal;
  }
  EXPECT_FALSE(readJaw(Arm::kGold, ServoKind::kServoJaw, jointsAt({})).command);
  EXPECT_FALSE(readJaw(Arm::kGold, ServoKind::kServoJaw, jointsAt({0.1, 0.1})).command);
}

TEST(CrtkReader, NamesMayBeLeftOutButNotMixedUp) {
  sensor_msgs::JointState message = jointsAt({0.1, 1.2, -0.1, 0.4, 0.5, 0.6});
  message.name = {"shoulder", "elbow", "insertion", "tool_rotation", "wrist", "jaw_midline"};
  EXPECT_TRUE(readJoints(Arm::kGold, ServoKind::kServoJoints, message).command);
  std::swap(message.name[0], message.name[1]);
  EXPECT_FALSE(readJoints(Arm::kGold, ServoKind::kServoJoints, message).command);
  message.name.resize(5);
  EXPECT_FALSE(readJoints(Arm::kGold, ServoKind::kServoJoints, message).command);
}

TEST(CrtkReader, WhatIsNotFiniteIsRefused) {
  for (const double bad : {kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(readJoints(Arm::kGold, ServoKind::kServoJoints, jointsAt({0, 1, 0.4, 0, 0, bad})).command);
    EXPECT_FALSE(readJaw(Arm::kGold, ServoKind::kMoveJaw, jointsAt({bad})).command);
    EXPECT_FALSE(readPose(Arm::kGold, ServoKind::kServoPose, worldFrame(placed()), poseAt(0, bad, 0)).command);
    geometry_msgs::PoseStamped turned = poseAt(0, 0, 0);
    turned.pose.orientation.x = bad;
    EXPECT_FALSE(readPose(Arm::kGold, ServoKind::kServoPose, worldFrame(placed()), turned).command);
    geometry_msgs::TwistStamped twist;
    twist.twist.angular.z = bad;
    EXPECT_FALSE(readTwist(Arm::kGold, worldFrame(placed()), twist).command);
  }
}

TEST(CrtkReader, AnOrientationHasLengthOne) {
  geometry_msgs::PoseStamped message = poseAt(0.3, 0.0, 0.1);
  message.pose.orientation.w = 0.0;  // the value of a message that nobody filled
  const auto asked = readPose(Arm::kGold, ServoKind::kServoPose, worldFrame(placed()), message);
  EXPECT_FALSE(asked.command);
  EXPECT_NE(asked.refusal.find("quaternion"), std::string::npos) << asked.refusal;
  message.pose.orientation.w = 1.03;
  EXPECT_FALSE(readPose(Arm::kGold, ServoKind::kServoPose, worldFrame(placed()), message).command);
  message.pose.orientation.w = 0.995;
  const auto rounded = readPose(Arm::kGold, ServoKind::kServoPose, worldFrame(placed()), message);
  ASSERT_TRUE(rounded.command);
  const Quat& q = rounded.command->pose_B.q;
  EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0, 1e-12);
}

TEST(CrtkReader, APoseInTheWorldIsBroughtToTheBase) {
  // 0.1 m along x of W from B is -0.1 m along y of B. The identity in W is a rotation by -90 degrees about z of B.
  const auto asked =
      readPose(Arm::kGreen, ServoKind::kMovePose, worldFrame(placed()), poseAt(0.4, 0.02, 0.03, "world"));
  ASSERT_TRUE(asked.command);
  EXPECT_EQ(asked.command->kind, ServoKind::kMovePose);
  EXPECT_EQ(asked.command->arm, Arm::kGreen);
  expectVector(asked.command->pose_B.p, 0.02, -0.1, 0.03);
  expectTurn(asked.command->pose_B.q, 0, 0, -kHalf, kHalf);
}

TEST(CrtkReader, AnIncrementIsTurnedAndNotMoved) {
  // A rotation by 90 degrees about x of W is one about -y of B.
  geometry_msgs::PoseStamped message = poseAt(0.001, 0.0, 0.002);
  message.pose.orientation.x = message.pose.orientation.w = kHalf;
  const auto asked = readPose(Arm::kGold, ServoKind::kServoPoseBy, worldFrame(placed()), message);
  ASSERT_TRUE(asked.command);
  expectVector(asked.command->pose_B.p, 0.0, -0.001, 0.002);
  expectTurn(asked.command->pose_B.q, 0, -kHalf, 0, kHalf);
}

TEST(CrtkReader, ATwistIsTurned) {
  geometry_msgs::TwistStamped message;
  message.header.frame_id = "world";
  message.twist.linear.x = 0.01;
  message.twist.angular.y = 0.5;
  const auto asked = readTwist(Arm::kGold, worldFrame(placed()), message);
  ASSERT_TRUE(asked.command);
  EXPECT_EQ(asked.command->kind, ServoKind::kServoTwist);
  expectVector(asked.command->v_B, 0.0, -0.01, 0.0);
  expectVector(asked.command->w_B, 0.5, 0.0, 0.0);
}

TEST(CrtkReader, LocalIsTheBaseItself) {
  const auto asked = readPose(Arm::kGreen, ServoKind::kServoPose, baseFrame(Arm::kGreen), poseAt(0.1, 0.2, 0.3));
  ASSERT_TRUE(asked.command);
  expectVector(asked.command->pose_B.p, 0.1, 0.2, 0.3);
  expectTurn(asked.command->pose_B.q, 0, 0, 0, 1);
}

TEST(CrtkReader, AFrameIsTheRightOneOrNone) {
  const CrtkFrame world = worldFrame(placed()), base = baseFrame(Arm::kGreen);
  const auto is_taken = [](const CrtkFrame& frame, const std::string& name) {
    return readPose(Arm::kGreen, ServoKind::kServoPose, frame, poseAt(0, 0, 0, name)).command.has_value();
  };
  EXPECT_TRUE(is_taken(world, ""));
  EXPECT_TRUE(is_taken(world, "world"));
  EXPECT_FALSE(is_taken(world, "model/base_link_R"));
  EXPECT_TRUE(is_taken(base, "model/base_link_R"));
  EXPECT_TRUE(is_taken(base, "robot/base_link_R"));
  EXPECT_FALSE(is_taken(base, "model/base_link_L")) << "the frame of the other arm";
  EXPECT_FALSE(is_taken(base, "world"));
  const auto asked = readPose(Arm::kGreen, ServoKind::kServoPose, world, poseAt(0, 0, 0, "camera"));
  EXPECT_EQ(asked.refusal, "servo_cp: in frame \"camera\"; it is world or no frame_id");
}

TEST(CrtkReader, TheRobotsOwnBranchTurnsItsBase) {
  // T_crtk_in_r0 of its crtk_motion_api.cpp: gold rows (0,-1,0) (0,0,-1) (1,0,0), green (0,1,0) (0,0,1) (1,0,0). The
  // commanded pose is its inverse times the transform.
  geometry_msgs::TransformStamped message;
  message.transform.translation.x = 0.1;
  message.transform.translation.y = 0.2;
  message.transform.translation.z = 0.3;
  message.transform.rotation.w = 1.0;
  const auto gold = readTransform(Arm::kGold, ServoKind::kServoPoseBy, ravenFrame(Arm::kGold), message);
  ASSERT_TRUE(gold.command);
  expectVector(gold.command->pose_B.p, 0.3, -0.1, -0.2);
  expectTurn(gold.command->pose_B.q, 0, 0, 0, 1);
  const auto green = readTransform(Arm::kGreen, ServoKind::kServoPose, ravenFrame(Arm::kGreen), message);
  ASSERT_TRUE(green.command);
  expectVector(green.command->pose_B.p, 0.3, 0.1, 0.2);
  // The inverse of a cyclic exchange of the axes is a rotation by 120 degrees about their diagonal.
  expectTurn(green.command->pose_B.q, 0.5, 0.5, 0.5, 0.5);
}

/** Limits as wide as a Raven's, in round numbers. */
ArmGeometry limited() {
  ArmGeometry geometry{};
  geometry.q_min = {0.0, 0.8, 0.23, -3.0, -1.5, -1.5, -1.4};
  geometry.q_max = {1.5, 2.4, 0.56, 3.0, 1.5, 1.4, 1.5};
  return geometry;
}

CrtkAsked ravenAsks(Arm arm, ServoKind kind, const std::vector<double>& positions) {
  return readRavenJoints(limited(), arm, kind, jointsAt(positions));
}

TEST(CrtkReader, TheRobotsOwnBranchAsksForSevenJoints) {
  const auto asked = ravenAsks(Arm::kGreen, ServoKind::kServoJoints, {0.1, 1.2, 0.4, 0.3, 0.2, 0.25, 0.75});
  ASSERT_TRUE(asked.command && asked.jaw);
  EXPECT_EQ(asked.command->kind, ServoKind::kServoJoints);
  EXPECT_EQ(asked.command->joints, (ServoJoints{0.1, 1.2, 0.4, 0.3, 0.2, 0.25}))
      << "the mid-line is half of the graspers' difference";
  EXPECT_EQ(asked.jaw->kind, ServoKind::kServoJaw);
  EXPECT_EQ(asked.jaw->arm, Arm::kGreen);
  EXPECT_EQ(asked.jaw->jaw, 1.0);
  std::vector<double> steps(15, 0.0);  // as raven2_CRTK_Python_controller sends them
  steps[1] = 0.001;
  steps[6] = 0.002;
  const auto by = ravenAsks(Arm::kGold, ServoKind::kServoJointsBy, steps);
  ASSERT_TRUE(by.command && by.jaw);
  EXPECT_EQ(by.command->joints, (ServoJoints{0, 0.001, 0, 0, 0, 0.001}));
  EXPECT_EQ(by.jaw->kind, ServoKind::kServoJawBy);
  EXPECT_EQ(by.jaw->jaw, 0.002);
  EXPECT_FALSE(ravenAsks(Arm::kGold, ServoKind::kServoJoints, steps).command);
  steps.resize(6);
  EXPECT_FALSE(ravenAsks(Arm::kGold, ServoKind::kServoJointsBy, steps).command);
  steps.assign(7, kNan);
  EXPECT_FALSE(ravenAsks(Arm::kGold, ServoKind::kServoJointsBy, steps).command);
}

TEST(CrtkReader, ASeventhJointThatStaysAsksNothingOfTheJaws) {
  const auto still = ravenAsks(Arm::kGold, ServoKind::kServoJointsBy, {0.001, 0, 0, 0, 0, 0, 0});
  EXPECT_TRUE(still.command);
  EXPECT_FALSE(still.jaw) << "a command for the jaws would end a move of the jaws";
  const auto turned = ravenAsks(Arm::kGold, ServoKind::kServoJointsBy, {0, 0, 0, 0, 0, -0.001, 0.001});
  ASSERT_TRUE(turned.command);
  EXPECT_DOUBLE_EQ(turned.command->joints.back(), 0.001) << "both graspers rotate in one direction";
  EXPECT_FALSE(turned.jaw);
  EXPECT_TRUE(ravenAsks(Arm::kGold, ServoKind::kServoJoints, {0.1, 1.2, 0.4, 0, 0, 0, 0}).jaw)
      << "closed is a position, not a step";
}

TEST(CrtkReader, JawsBeyondTheirLimitsHoldTheArmBackAndTheArmTheJaws) {
  const auto jaws = ravenAsks(Arm::kGold, ServoKind::kServoJoints, {0.1, 1.2, 0.4, 0, 0, 0.8, 0.8});
  EXPECT_FALSE(jaws.command || jaws.jaw);
  EXPECT_EQ(jaws.refusal, "servo_jp: jaw at 1.6 rad, at most 1.57 rad");
  const auto elbow = ravenAsks(Arm::kGold, ServoKind::kServoJoints, {0.1, 0.7, 0.4, 0, 0, 0.2, 0.2});
  EXPECT_FALSE(elbow.command || elbow.jaw);
  EXPECT_EQ(elbow.refusal, "servo_jp: elbow at 0.7 rad, at least 0.8 rad");
  const auto midline = ravenAsks(Arm::kGold, ServoKind::kServoJoints, {0.1, 1.2, 0.4, 0, 0, -1.55, 1.55});
  EXPECT_EQ(midline.refusal, "servo_jp: jaw_midline at 1.55 rad, at most 1.5 rad");
  const auto far = ravenAsks(Arm::kGold, ServoKind::kServoJointsBy, {0, 0, 2.0, 0, 0, 0.1, 0.1});
  EXPECT_TRUE(far.command && far.jaw) << "only the loop knows where a step begins, and so checks its end";
}

TEST(CrtkReader, TheRobotsOwnBranchGivesATurnPerSecond) {
  geometry_msgs::TransformStamped message;
  message.transform.translation.z = 0.01;
  message.transform.rotation.x = std::sin(0.35);  // 0.7 rad about x: of B gold -y, green y
  message.transform.rotation.w = std::cos(0.35);
  const auto gold = readTransformTwist(Arm::kGold, ravenFrame(Arm::kGold), message);
  ASSERT_TRUE(gold.command);
  expectVector(gold.command->v_B, 0.01, 0.0, 0.0);
  expectVector(gold.command->w_B, 0.0, -0.7, 0.0);
  message.transform.rotation.x = std::sin(2.0);  // 4 rad, more than pi
  message.transform.rotation.w = std::cos(2.0);
  const auto fast = readTransformTwist(Arm::kGreen, ravenFrame(Arm::kGreen), message);
  ASSERT_TRUE(fast.command);
  expectVector(fast.command->w_B, 0.0, 4.0, 0.0);
  message.transform.rotation.x = 0.0;
  message.transform.rotation.w = 1.0;
  const auto still = readTransformTwist(Arm::kGreen, ravenFrame(Arm::kGreen), message);
  ASSERT_TRUE(still.command);
  expectVector(still.command->w_B, 0.0, 0.0, 0.0);
}

/** Both bounds of every joint, on both arms. A value inside is accepted, one outside refused with the violated bound.
 *  The mid-line has grasper 1's lower limit and grasper 2's upper one, the jaws -10 to 90 degrees (raven2.md). */
TEST(CrtkReader, BothBoundsOfEveryJointHold) {
  const std::array<std::array<double, 2>, 7> bounds{
      {{0.0, 1.5}, {0.8, 2.4}, {0.23, 0.56}, {-3.0, 3.0}, {-1.5, 1.5}, {-1.5, 1.5}, {-0.174, 1.57}}};
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < bounds.size(); ++j) {
      for (const bool is_high : {false, true}) {
        const double bound = bounds[j][is_high ? 1 : 0], out = is_high ? 6e-5 : -6e-5;
        const auto positionsAt = [&](double value) {
          std::array<double, 7> wanted{0.1, 1.2, 0.4, 0.0, 0.0, 0.0, 0.5};  // five joints, mid-line, opening
          wanted[j] = value;
          return std::vector<double>{wanted[0],
                                     wanted[1],
                                     wanted[2],
                                     wanted[3],
                                     wanted[4],
                                     wanted[6] / 2 - wanted[5],
                                     wanted[6] / 2 + wanted[5]};
        };
        EXPECT_TRUE(ravenAsks(arm, ServoKind::kServoJoints, positionsAt(bound - out)).command) << j << is_high;
        EXPECT_TRUE(ravenAsks(arm, ServoKind::kServoJoints, positionsAt(bound + 0.8 * out)).command)
            << j << is_high << ": a set point at a limit is hardly beyond it";
        const CrtkAsked beyond = ravenAsks(arm, ServoKind::kServoJoints, positionsAt(bound + out));
        EXPECT_FALSE(beyond.command || beyond.jaw) << j << is_high;
        EXPECT_NE(beyond.refusal.find(is_high ? "at most" : "at least"), std::string::npos) << beyond.refusal;
      }
    }
  }
}

TEST(CrtkReader, TheRobotsOwnBranchMayAskForTheShoulderAlone) {
  for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kServoJointsBy}) {
    const auto asked = ravenAsks(Arm::kGreen, kind, {0.2});
    ASSERT_TRUE(asked.command);
    EXPECT_EQ(asked.command->kind, kind);
    EXPECT_EQ(asked.command->joints, (ServoJoints{0.2, 0, 0, 0, 0, 0}));
    EXPECT_EQ(asked.command->is_shoulder, 1);
    EXPECT_FALSE(asked.jaw);
  }
  EXPECT_FALSE(ravenAsks(Arm::kGold, ServoKind::kServoJoints, {kNan}).command);
  EXPECT_FALSE(ravenAsks(Arm::kGold, ServoKind::kServoJoints, {0.1, 0.2}).command);
  EXPECT_FALSE(ravenAsks(Arm::kGold, ServoKind::kServoJoints, {}).command);
}

TEST(CrtkReader, TheRobotsOwnBranchAsksForRatesOfSevenJointsOrMore) {
  sensor_msgs::JointState message;
  message.velocity = {0.1, 0.2, 0.01, 0.3, 0.4, -0.1, 0.3};
  for (const std::size_t more : {0U, 8U}) {
    message.velocity.resize(kJointCount + more, 9.0);
    const auto asked = readRavenJoints(limited(), Arm::kGold, ServoKind::kServoRates, message);
    ASSERT_TRUE(asked.command);
    EXPECT_EQ(asked.command->kind, ServoKind::kServoRates);
    EXPECT_EQ(asked.command->joints, (ServoJoints{0.1, 0.2, 0.01, 0.3, 0.4, 0.2}));
    EXPECT_FALSE(asked.jaw);
  }
  message.velocity.resize(6);
  EXPECT_FALSE(readRavenJoints(limited(), Arm::kGold, ServoKind::kServoRates, message).command);
}

TEST(CrtkReader, OfTheRavensGraspersTheFirstNumberIsTheOpening) {
  const auto one = readRavenJaw(Arm::kGold, ServoKind::kServoJaw, jointsAt({0.4}));
  const auto seven = readRavenJaw(Arm::kGold, ServoKind::kServoJaw, jointsAt({0.4, 1, 2, 3, 4, 5, 6}));
  ASSERT_TRUE(one.command && seven.command);
  EXPECT_EQ(one.command->jaw, 0.4);
  EXPECT_EQ(seven.command->jaw, 0.4);
  EXPECT_FALSE(readRavenJaw(Arm::kGold, ServoKind::kServoJaw, jointsAt({0.4, 0.4})).command);
}

/** crtk_robot.cpp of crtk-cpp names the joint of each grasper command `grasp`. That branch ignores names. */
TEST(CrtkReader, TheRavensGraspersMayHaveAnyName) {
  for (const Arm arm : kArms) {
    for (const ServoKind kind : {ServoKind::kServoJaw, ServoKind::kServoJawBy, ServoKind::kMoveJaw}) {
      for (const std::size_t count : {1U, 7U, 15U}) {
        sensor_msgs::JointState message = jointsAt(std::vector<double>(count, 0.9));
        message.position[0] = 0.4;
        message.name = {"grasp"};
        const CrtkAsked asked = readRavenJaw(arm, kind, message);
        ASSERT_TRUE(asked.command) << count << ": " << asked.refusal;
        EXPECT_EQ(asked.command->kind, kind);
        EXPECT_EQ(asked.command->arm, arm);
        EXPECT_EQ(asked.command->jaw, 0.4);
      }
    }
    sensor_msgs::JointState squeeze;
    squeeze.name = {"grasp"};
    squeeze.effort = {0.02};
    ASSERT_TRUE(readRavenJaw(arm, ServoKind::kServoJawForce, squeeze).command);
    EXPECT_EQ(readRavenJaw(arm, ServoKind::kServoJawForce, squeeze).command->jaw, 0.02);
  }
}

TEST(CrtkReader, RatesAndForcesAreWhatAMessageSaysOfThem) {
  sensor_msgs::JointState message = jointsAt({9, 9, 9, 9, 9, 9});
  message.velocity = {0.1, 0.2, 0.03, 0.4, 0.5, 0.6};
  message.effort = {1, 2, 3, 4, 5, 6};
  const auto rates = readJoints(Arm::kGold, ServoKind::kServoRates, message);
  const auto forces = readJoints(Arm::kGreen, ServoKind::kServoForces, message);
  ASSERT_TRUE(rates.command && forces.command);
  EXPECT_EQ(rates.command->joints, (ServoJoints{0.1, 0.2, 0.03, 0.4, 0.5, 0.6}));
  EXPECT_EQ(forces.command->joints, (ServoJoints{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(forces.command->arm, Arm::kGreen);
  message.velocity.pop_back();
  message.effort.clear();
  EXPECT_NE(readJoints(Arm::kGold, ServoKind::kServoRates, message).refusal.find("servo_jv: 5 velocities"),
            std::string::npos);
  EXPECT_NE(readJoints(Arm::kGold, ServoKind::kServoForces, message).refusal.find("servo_jf: 0 efforts"),
            std::string::npos);
  sensor_msgs::JointState jaw;
  jaw.effort = {0.02};
  const auto squeeze = readJaw(Arm::kGold, ServoKind::kServoJawForce, jaw);
  ASSERT_TRUE(squeeze.command);
  EXPECT_EQ(squeeze.command->jaw, 0.02);
}

/** B is rotated by 90 degrees about z, so a force of 1 N along x of W at the tip acts along -y of B. */
TEST(CrtkReader, AWrenchIsTurnedAndItsTorqueBroughtToTheBase) {
  geometry_msgs::WrenchStamped message;
  message.wrench.force.x = 1.0;
  message.wrench.torque.z = 0.5;
  const auto tip = readWrench(Arm::kGold, worldFrame(placed()), WrenchFrame::kTip, message);
  ASSERT_TRUE(tip.command);
  expectVector(tip.command->force, 0.0, -1.0, 0.0);
  expectVector(tip.command->torque, 0.0, 0.0, 0.5);
  message.wrench.force.x = 0.0;
  message.wrench.force.y = 2.0;  // 0.3 m from B's origin: -0.6 Nm about z
  const auto spatial = readWrench(Arm::kGold, worldFrame(placed()), WrenchFrame::kOrigin, message);
  ASSERT_TRUE(spatial.command);
  expectVector(spatial.command->force, 2.0, 0.0, 0.0);
  expectVector(spatial.command->torque, 0.0, 0.0, 0.5 - 0.6);
  const auto body = readWrench(Arm::kGreen, {"", {}, Pose{}}, WrenchFrame::kBody, message);
  ASSERT_TRUE(body.command);
  expectVector(body.command->force, 0.0, 2.0, 0.0);
  EXPECT_EQ(body.command->frame, WrenchFrame::kBody);
  message.header.frame_id = "camera";
  EXPECT_FALSE(readWrench(Arm::kGold, worldFrame(placed()), WrenchFrame::kTip, message).command);
  message.header.frame_id = "world";
  message.wrench.torque.y = kNan;
  EXPECT_FALSE(readWrench(Arm::kGold, worldFrame(placed()), WrenchFrame::kTip, message).command);
}

TEST(CrtkReader, ASettingIsANumber) {
  const auto ratio = readNumber(Arm::kGold, ServoKind::kRatio, 0.5);
  ASSERT_TRUE(ratio.command);
  EXPECT_EQ(ratio.command->number, 0.5);
  EXPECT_FALSE(readNumber(Arm::kGold, ServoKind::kRatio, kNan).command);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
