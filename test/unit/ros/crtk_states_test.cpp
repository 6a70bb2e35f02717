#include "ros/crtk/crtk_states.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "ros/crtk/crtk_reader.h"
#include "ros/crtk/crtk_wrench.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kDegree = kPi / 180.0;

/** The first columns of raven2.md 2.4: shoulder, elbow, insertion, roll, wrist, mid-line. Jaws open by 20 degrees. */
JointArray joints(double shoulder, double elbow, double insertion, double roll, double wrist, double mid) {
  JointArray q{shoulder * kDegree, elbow * kDegree, insertion, roll * kDegree, wrist * kDegree, 0.0, 0.0};
  q[kGrasp1] = (10.0 - mid) * kDegree;
  q[kGrasp2] = (10.0 + mid) * kDegree;
  return q;
}

class CrtkMeasuredTest : public ::testing::Test {
 protected:
  CrtkMeasuredTest() {
    for (ArmState& arm : model.arms)
      arm.q = joints(60, 120, 0.35, -90, -40, 25);
    for (RobotArmState& arm : robot.arms)
      arm.q = joints(45, 100, 0.45, 30, 20, -15);
    robot.connected = 1;
    robot.frame = 10;
    model.robot_fresh = 1;
  }

  CrtkMeasured of(Arm arm) const {
    MeasuredSource source;
    source.take(arm, model, robot, ros::Time(1.0));
    return measured(geometry, arm, source.q(), source.dq(), at(model.arms, arm).tau);
  }

  const ArmGeometry geometry =
      config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").arms.geometry;
  ModelState model;
  RobotState robot;
};

void expectNear(const Vector3& v, double x, double y, double z, double tolerance) {
  EXPECT_NEAR(v.x(), x, tolerance);
  EXPECT_NEAR(v.y(), y, tolerance);
  EXPECT_NEAR(v.z(), z, tolerance);
}

TEST_F(CrtkMeasuredTest, IsTheRobotWhereTheTablesPutIt) {
  // raven2.md 2.4
  const CrtkMeasured gold = of(Arm::kGold), green = of(Arm::kGreen);
  expectNear(gold.X_BT.p, -0.026873, -0.013929, 0.011894, 1e-6);
  expectNear(green.X_BT.p, -0.028202, 0.014267, 0.007665, 1e-6);
  EXPECT_NEAR(green.X_BT.R(2, 1), 0.880881, 1e-6);
  EXPECT_NEAR(gold.q[3], 30 * kDegree, 1e-12);
  EXPECT_NEAR(gold.q[5], -15 * kDegree, 1e-12) << "the jaws' mid-line";
  EXPECT_NEAR(gold.jaw, 20 * kDegree, 1e-12);
}

TEST_F(CrtkMeasuredTest, IsTheModelUntilARobotIsThere) {
  const Vector3 of_model(-0.069288, -0.078771, 0.077158);  // raven2.md 2.4
  model.robot_fresh = 0;
  EXPECT_NEAR((of(Arm::kGold).X_BT.p - of_model).norm(), 0.0, 2e-6);
  model.robot_fresh = 1;
  robot.connected = 0;
  EXPECT_NEAR((of(Arm::kGold).X_BT.p - of_model).norm(), 0.0, 2e-6);
  robot.connected = 1;
  robot.frame = 0;
  EXPECT_NEAR((of(Arm::kGold).X_BT.p - of_model).norm(), 0.0, 2e-6);
}

/** Compares the twist with differences of the tip's poses along q + t dq. */
TEST_F(CrtkMeasuredTest, TheTwistIsHowTheTipMoves) {
  for (const Arm arm : kArms) {
    const JointArray q = at(robot.arms, arm).q;
    const JointArray dq{0.2, -0.3, 0.05, 0.7, -0.4, 0.3, 0.5};
    at(robot.arms, arm).dq = dq;
    const CrtkMeasured m = of(arm);
    const double h = 1e-6;
    JointArray before = q, after = q;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      before[j] -= h * dq[j];
      after[j] += h * dq[j];
    }
    const Pose X = kinematics::forward(geometry, arm, before), Y = kinematics::forward(geometry, arm, after);
    const Vector3 v = (Y.p - X.p) / (2 * h);
    const Matrix3 turn = (Y.R - X.R) / (2 * h) * m.X_BT.R.transpose();
    EXPECT_NEAR((m.v_B - v).norm(), 0.0, 1e-8) << name(arm);
    EXPECT_NEAR((m.w_B - Vector3(turn(2, 1), turn(0, 2), turn(1, 0))).norm(), 0.0, 1e-7) << name(arm);
    EXPECT_NEAR(m.jaw_rate, 0.8, 1e-12);
    EXPECT_NEAR(m.dq[5], 0.1, 1e-12);
  }
}

/** Compares each column with differences of the tip's poses. Opening the jaws does not move the tip. */
TEST_F(CrtkMeasuredTest, TheJacobiansColumnsAreTheSixJoints) {
  const CrtkMeasured m = of(Arm::kGreen);
  const double h = 1e-6;
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const auto moved = [&](double by) {
      JointArray q = robot.arms[1].q;
      if (j < 5) q[j] += by;
      if (j == 5) q[kGrasp1] -= by;
      if (j == 5) q[kGrasp2] += by;
      return kinematics::forward(geometry, Arm::kGreen, q);
    };
    const Pose X = moved(-h), Y = moved(h);
    const auto column = static_cast<Eigen::Index>(j);
    EXPECT_NEAR((m.J_B.col(column).head<3>() - (Y.p - X.p) / (2 * h)).norm(), 0.0, 1e-8) << j;
    const Matrix3 turn = (Y.R - X.R) / (2 * h) * m.X_BT.R.transpose();
    const Vector3 w(turn(2, 1), turn(0, 2), turn(1, 0));
    EXPECT_NEAR((m.J_B.col(column).tail<3>() - w).norm(), 0.0, 1e-7) << j;
  }
}

TEST_F(CrtkMeasuredTest, EffortsDoTheWorkThatTheModelsTorquesDo) {
  model.arms[0].tau = {1.0, 2.0, 3.0, 0.4, 0.5, 0.06, 0.02};
  const JointArray dq{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.9};
  robot.arms[0].dq = dq;
  const CrtkMeasured m = of(Arm::kGold);
  double power = 0.0, told = m.jaw_effort * m.jaw_rate;
  for (std::size_t j = 0; j < kJointCount; ++j)
    power += model.arms[0].tau[j] * dq[j];
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    told += m.effort[j] * m.dq[j];
  EXPECT_NEAR(told, power, 1e-12);
  EXPECT_EQ(m.effort[kInsertion], 3.0);
}

/** A plan that the model tracks, or a stall of the network, must not make the robot's values leap. */
TEST_F(CrtkMeasuredTest, OnceARobotWasThereItIsThatOneOrNothing) {
  for (const Arm arm : kArms) {
    MeasuredSource source;
    model.robot_fresh = 0;
    model.tick = 100;
    source.take(arm, model, robot, ros::Time(0.1));
    EXPECT_EQ(source.from(), MeasuredFrom::kModel);
    EXPECT_EQ(source.stamp(), ros::Time(0.1));
    model.robot_fresh = 1;
    model.tick = 200;
    source.take(arm, model, robot, ros::Time(0.2));
    EXPECT_EQ(source.from(), MeasuredFrom::kRobot);
    EXPECT_EQ(source.q(), at(robot.arms, arm).q);
    model.robot_fresh = 0;
    const JointArray last = at(robot.arms, arm).q;
    for (model.tick = 202; model.tick <= 200 + MeasuredSource::kRepeated; model.tick += 2) {
      source.take(arm, model, robot, ros::Time(1e-3 * static_cast<double>(model.tick)));
      ASSERT_EQ(source.from(), MeasuredFrom::kStale);
      ASSERT_EQ(source.stamp(), ros::Time(0.2)) << "the stamp of the robot's last state";
      ASSERT_EQ(source.q(), last);
    }
    source.take(arm, model, robot, ros::Time(9.0));
    EXPECT_EQ(source.from(), MeasuredFrom::kNone);
    EXPECT_EQ(source.age(), MeasuredSource::kRepeated + 2);
    robot.connected = 0;
    source.take(arm, model, robot, ros::Time(9.1));
    EXPECT_EQ(source.from(), MeasuredFrom::kNone) << "the model does not replace the robot";
    robot.connected = model.robot_fresh = 1;
    source.take(arm, model, robot, ros::Time(9.2));
    EXPECT_EQ(source.from(), MeasuredFrom::kRobot);
    EXPECT_EQ(source.stamp(), ros::Time(9.2));
  }
}

/** A body that is rigid with the tip and at the world's origin moves as the spatial Jacobian gives. Contact forces on
 *  the tip do the same work through each Jacobian and its wrench. */
TEST_F(CrtkMeasuredTest, JacobiansAndWrenchesOfAllFramesDoTheSameWork) {
  const Pose X_WB{Matrix3(Eigen::AngleAxisd(0.7, Vector3(1.0, 2.0, -0.5).normalized())), Vector3(0.2, -0.1, 0.3)};
  const CrtkFrame world = worldFrame(X_WB);
  for (const Arm arm : kArms) {
    const CrtkMeasured m = of(arm);
    const Pose X_WT = X_WB * m.X_BT;
    const ArmWrench at_tip{Vector3(1.0, -2.0, 3.0), Vector3(0.1, 0.2, -0.3)};
    const ArmWrench body = alongTip(at_tip, X_WT), spatial = aboutOrigin(at_tip, X_WT);
    const auto forces = [](const CrtkFrame& frame, const ServoJacobian& J_B, const ArmWrench& wrench) {
      std_msgs::Float64MultiArray message;
      fill(frame, J_B, &message);
      const Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> J(message.data.data());
      Eigen::Matrix<double, 6, 1> w;
      w << wrench.force_W, wrench.torque_W;
      return Eigen::Matrix<double, 6, 1>(J.transpose() * w);
    };
    const auto wanted = forces(world, m.J_B, at_tip);
    EXPECT_LT((forces({"", {}, m.X_BT}, m.J_B, body) - wanted).norm(), 1e-9) << name(arm);
    EXPECT_LT((forces(world, atOrigin(world, m), spatial) - wanted).norm(), 1e-9) << name(arm);
    EXPECT_GT((spatial.torque_W - at_tip.torque_W).norm(), 0.1) << "the torques must differ enough";
  }
}

TEST(CrtkSetpointRate, IsHowFarItMovedInTheTicksBetween) {
  SetpointRate rate;
  ServoArmState arm;
  arm.setpoint_q = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  const auto of = [&](Tick tick) { return rate.of(tick, arm.setpoint_q, arm.setpoint_jaw); };
  EXPECT_EQ(of(10), ServoJoints{}) << "there is no set point before";
  arm.setpoint_q[1] += 0.004;
  arm.setpoint_jaw = 0.001;
  EXPECT_NEAR(of(12)[1], 2.0, 1e-9);
  EXPECT_NEAR(rate.jaw(), 0.5, 1e-9);
  arm.setpoint_q[1] += 1.0;
  EXPECT_NEAR(of(12)[1], 2.0, 1e-9) << "the same tick";
  EXPECT_EQ(of(2000), ServoJoints{}) << "a gap gives no rate";
  EXPECT_EQ(of(5), ServoJoints{}) << "an older tick begins again";
}

CrtkJoints someJoints() {
  CrtkJoints joints;
  joints.q = {1, 2, 3, 4, 5, 0.25};
  joints.dq = {7, 8, 9, 10, 11, 0.5};
  joints.effort = {13, 14, 15, 16, 17, 0.125};
  joints.jaw = 1.0;
  joints.jaw_rate = 2.0;
  joints.jaw_effort = 4.0;
  return joints;
}

TEST(CrtkStates, JointsComeWithNamesAndAllThreeOfTheirLengths) {
  sensor_msgs::JointState message;
  fill(someJoints(), &message);
  EXPECT_EQ(message.name,
            (std::vector<std::string>{"shoulder", "elbow", "insertion", "tool_rotation", "wrist", "jaw_midline"}));
  EXPECT_EQ(message.position, (std::vector<double>{1, 2, 3, 4, 5, 0.25}));
  EXPECT_EQ(message.velocity, (std::vector<double>{7, 8, 9, 10, 11, 0.5}));
  EXPECT_EQ(message.effort, (std::vector<double>{13, 14, 15, 16, 17, 0.125}));
  fillJaw(someJoints(), &message);
  EXPECT_EQ(message.name, std::vector<std::string>{"jaw"});
  EXPECT_EQ(message.position, std::vector<double>{1.0});
  EXPECT_EQ(message.velocity, std::vector<double>{2.0});
  EXPECT_EQ(message.effort, std::vector<double>{4.0});
}

/** The graspers are at half the opening minus and plus the mid-line. Torques on them do the same work. */
TEST(CrtkStates, TheRobotsOwnBranchHasSevenJoints) {
  sensor_msgs::JointState message;
  fillRaven(Arm::kGreen, someJoints(), &message);
  EXPECT_EQ(message.name, (std::vector<std::string>{"green_shoulder", "green_elbow", "green_ins", "green_roll",
                                                    "green_wrist", "green_jaw1", "green_jaw2"}));
  EXPECT_EQ(message.position, (std::vector<double>{1, 2, 3, 4, 5, 0.25, 0.75}));
  EXPECT_EQ(message.velocity, (std::vector<double>{7, 8, 9, 10, 11, 0.5, 1.5}));
  ASSERT_EQ(message.effort.size(), 7U);
  EXPECT_EQ(message.effort[2], 15.0);
  EXPECT_EQ(message.effort[5] * 0.5 + message.effort[6] * 1.5, 0.125 * 0.5 + 4.0 * 2.0);
  EXPECT_EQ(message.effort[6] - message.effort[5], 0.125);
  fillRavenGrasp(Arm::kGold, someJoints(), &message);
  EXPECT_EQ(message.name, (std::vector<std::string>{"gold_grasp", "gold_jaw1", "gold_jaw2"}));
  EXPECT_EQ(message.position, (std::vector<double>{1.0, 0.25, 0.75}));
  EXPECT_EQ(message.velocity, (std::vector<double>{2.0, 0.5, 1.5}));
  EXPECT_EQ(message.effort.size(), 3U);
}

/** A published pose that comes back as a command asks for that pose. */
TEST(CrtkStates, APoseGoesOutAndComesBack) {
  Pose X_WB, X_BT;
  X_WB.R = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  X_WB.p = Vector3(0.1, -0.2, 0.3);
  X_BT.R = Eigen::AngleAxisd(-1.1, Vector3(0, 1, 1).normalized()).toRotationMatrix();
  X_BT.p = Vector3(-0.07, 0.02, 0.01);
  for (const CrtkFrame& frame : {worldFrame(X_WB), baseFrame(Arm::kGold), ravenFrame(Arm::kGreen)}) {
    geometry_msgs::PoseStamped pose;
    fill(frame, X_BT, &pose);
    pose.header.frame_id = frame.name;
    const auto asked = readPose(Arm::kGold, ServoKind::kServoPose, frame, pose);
    ASSERT_TRUE(asked.command) << asked.refusal;
    EXPECT_NEAR((toEigen(asked.command->pose_B).p - X_BT.p).norm(), 0.0, 1e-12) << frame.name;
    EXPECT_NEAR((toEigen(asked.command->pose_B).R - X_BT.R).norm(), 0.0, 1e-12) << frame.name;
  }
  geometry_msgs::PoseStamped pose;
  fill(worldFrame(X_WB), X_BT, &pose);
  const Vector3 p_W = X_WB * X_BT.p;
  EXPECT_NEAR(pose.pose.position.x, p_W.x(), 1e-12);
  EXPECT_NEAR(pose.pose.position.z, p_W.z(), 1e-12);
  geometry_msgs::TransformStamped transform;
  fill(ravenFrame(Arm::kGreen), X_BT, &transform);
  EXPECT_NEAR(transform.transform.translation.x, 0.02, 1e-12) << "y of B";
  EXPECT_NEAR(transform.transform.translation.y, 0.01, 1e-12) << "z of B";
  EXPECT_NEAR(transform.transform.translation.z, -0.07, 1e-12) << "x of B";
}

TEST(CrtkStates, AJacobianIsToldRowByRowInItsFrame) {
  Pose X_WB;
  X_WB.R << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // x of B is y of W
  ServoJacobian J_B;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column)
      J_B(row, column) = 10 * row + column;
  }
  std_msgs::Float64MultiArray message;
  fill(worldFrame(X_WB), J_B, &message);
  ASSERT_EQ(message.layout.dim.size(), 2U);
  EXPECT_EQ(message.layout.dim[0].size, 6U);
  EXPECT_EQ(message.layout.dim[0].stride, 36U);
  EXPECT_EQ(message.layout.dim[1].size, 6U);
  EXPECT_EQ(message.layout.dim[1].stride, 6U);
  ASSERT_EQ(message.data.size(), 36U);
  EXPECT_EQ(message.data[0 * 6 + 4], -14.0) << "x of W is -y of B";
  EXPECT_EQ(message.data[1 * 6 + 4], 4.0);
  EXPECT_EQ(message.data[2 * 6 + 5], 25.0);
  EXPECT_EQ(message.data[3 * 6 + 0], -40.0) << "the rotational rows change axes as well";
  EXPECT_EQ(message.data[4 * 6 + 3], 33.0);
  fill(baseFrame(Arm::kGold), J_B, &message);
  EXPECT_EQ(message.data[3 * 6 + 1], 31.0);
}

TEST(CrtkStates, ATwistIsToldInItsFrame) {
  Pose X_WB;
  X_WB.R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  X_WB.p = Vector3(1.0, 2.0, 3.0);
  geometry_msgs::TwistStamped message;
  fill(worldFrame(X_WB), Vector3(0.01, 0.02, 0.03), Vector3(0.1, 0.2, 0.3), &message);
  EXPECT_NEAR(message.twist.linear.x, -0.02, 1e-12);
  EXPECT_NEAR(message.twist.linear.y, 0.01, 1e-12);
  EXPECT_NEAR(message.twist.angular.x, -0.2, 1e-12);
  EXPECT_NEAR(message.twist.angular.z, 0.3, 1e-12);
}

/** Each arm has another pose, so that a mix-up of the arms' states shows. */
TEST_F(CrtkMeasuredTest, EachArmIsMeasuredByItsOwnState) {
  for (const bool has_robot : {true, false}) {
    model.robot_fresh = has_robot ? 1 : 0;
    for (const Arm arm : kArms) {
      at(robot.arms, arm).q = joints(45, 100, 0.45, 30, 20, arm == Arm::kGold ? -15 : 35);
      at(robot.arms, arm).dq = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, arm == Arm::kGold ? 0.7 : 0.9};
      at(model.arms, arm).q = joints(60, 120, 0.35, -90, arm == Arm::kGold ? -40 : 10, 25);
      at(model.arms, arm).tau[kElbow] = arm == Arm::kGold ? 1.5 : -2.5;
    }
    for (const Arm arm : kArms) {
      const JointArray& q = has_robot ? at(robot.arms, arm).q : at(model.arms, arm).q;
      const CrtkMeasured m = of(arm);
      EXPECT_EQ(m.effort[kElbow], at(model.arms, arm).tau[kElbow]) << name(arm);
      EXPECT_EQ(m.q[kWrist], q[kWrist]) << name(arm);
      EXPECT_NEAR(m.q[5], (q[kGrasp2] - q[kGrasp1]) / 2, 1e-12) << name(arm);
      EXPECT_NEAR((m.X_BT.p - kinematics::forward(geometry, arm, q).p).norm(), 0.0, 1e-12) << name(arm);
      const JointArray& dq = has_robot ? at(robot.arms, arm).dq : at(model.arms, arm).dq;
      EXPECT_NEAR(m.jaw_rate, dq[kGrasp1] + dq[kGrasp2], 1e-12) << name(arm);
    }
  }
}

TEST(CrtkSetpointRate, OfJawsIsZeroToo) {
  SetpointRate rate;
  ServoArmState arm;
  arm.setpoint_jaw = 0.4;
  rate.of(10, arm.setpoint_q, arm.setpoint_jaw);
  EXPECT_EQ(rate.jaw(), 0.0) << "there is no set point before";
  arm.setpoint_jaw = 0.5;
  rate.of(11, arm.setpoint_q, arm.setpoint_jaw);
  EXPECT_NEAR(rate.jaw(), 100.0, 1e-9);
  for (const Tick tick : {112, 50}) {
    arm.setpoint_jaw += 0.5;
    rate.of(tick, arm.setpoint_q, arm.setpoint_jaw);
    EXPECT_EQ(rate.jaw(), 0.0) << "a gap of over 100 ms, or a step back: " << tick;
  }
}

TEST(CrtkStates, TheRobotsOwnBranchNamesTheJointsByTheirArm) {
  for (const Arm arm : kArms) {
    const std::string prefix = std::string(name(arm)) + "_";
    sensor_msgs::JointState all, grasp;
    fillRaven(arm, someJoints(), &all);
    fillRavenGrasp(arm, someJoints(), &grasp);
    for (const auto& names : {all.name, grasp.name}) {
      for (const std::string& joint : names)
        EXPECT_EQ(joint.rfind(prefix, 0), 0U) << joint;
    }
    EXPECT_EQ(all.name.size(), 7U);
    EXPECT_EQ(grasp.name.size(), 3U);
    EXPECT_EQ(grasp.effort[0], 4.0) << "the effort of the jaws";
    EXPECT_EQ(grasp.effort[1], all.effort[5]);
    EXPECT_EQ(grasp.effort[2], all.effort[6]);
  }
}

/** doc/crtk.md. */
TEST(CrtkFrames, EachArmHasItsOwnNames) {
  CrtkConfig config;
  config.names = {"arm1", "arm2"};
  for (const CrtkDialect dialect : {CrtkDialect::kModern, CrtkDialect::kTransform}) {
    config.dialect = dialect;
    EXPECT_EQ(jawNamespace(config, Arm::kGold), "arm1/jaw");
    EXPECT_EQ(jawNamespace(config, Arm::kGreen), "arm2/jaw");
  }
  config.dialect = CrtkDialect::kRaven;
  EXPECT_EQ(jawNamespace(config, Arm::kGold), "grasp1");
  EXPECT_EQ(jawNamespace(config, Arm::kGreen), "grasp2");
  EXPECT_EQ(baseFrame(Arm::kGold).name, "model/base_link_L");
  EXPECT_EQ(baseFrame(Arm::kGreen).name, "model/base_link_R");
  EXPECT_EQ(baseFrame(Arm::kGold).allowed, (std::vector<std::string>{"model/base_link_L", "robot/base_link_L"}));
  EXPECT_EQ(baseFrame(Arm::kGreen).allowed, (std::vector<std::string>{"model/base_link_R", "robot/base_link_R"}));
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
