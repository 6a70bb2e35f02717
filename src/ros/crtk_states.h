#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64MultiArray.h>

#include "raven2_trainer/core/arms_config.h"
#include "raven2_trainer/core/servo.h"
#include "raven2_trainer/core/state.h"
#include "ros/crtk_frames.h"

// States of an arm as CRTK tells them. Messages are filled in place, so that they keep their memory.

namespace raven2_trainer::ros_bridge {

using ServoJacobian = Eigen::Matrix<double, 6, 6>;

/** An arm's joints and its jaws' opening. */
struct CrtkJoints {
  ServoJoints q{}, dq{}, effort{};         ///< [rad; m], [rad/s; m/s], [Nm; N] the model's
  double jaw{}, jaw_rate{}, jaw_effort{};  ///< [rad], [rad/s], [Nm]
};

/** An arm as measured: the robot's joints while it is there and fresh, else the model's; the rest follows from them. */
struct CrtkMeasured : CrtkJoints {
  Pose X_BT{};                               ///< of the tool tip, by forward kinematics of q
  Vector3 v_B{Vector3::Zero()};              ///< [m/s] of it, J dq
  Vector3 w_B{Vector3::Zero()};              ///< [rad/s]
  ServoJacobian J_B{ServoJacobian::Zero()};  ///< columns ServoJoints; rows 0 to 2 linear, 3 to 5 angular, both in B
};

/** [Nm; N] Torques and forces on the joints of control::servoJoints(): what does the same work. */
ServoJoints servoEfforts(const JointArray& tau) noexcept;
/** [Nm] Of the jaws' opening. */
double jawEffort(const JointArray& tau) noexcept;

CrtkMeasured measured(const ArmGeometry& geometry, Arm arm, const ModelState& model, const RobotState& robot) noexcept;

/** How fast the set point moves, by two of its states. */
class SetpointRate {
 public:
  /** [rad/s; m/s] since the set point of an earlier tick; 0 at first, after a gap and after a leap back. */
  const ServoJoints& of(Tick tick, const ServoArmState& arm) noexcept;
  double jaw() const noexcept { return jaw_rate_; }

 private:
  Tick tick_{-1};
  ServoJoints q_{}, rate_{};
  double jaw_{}, jaw_rate_{};
};

void fill(const CrtkJoints& joints, sensor_msgs::JointState* message);
/** The jaws' one joint. */
void fillJaw(const CrtkJoints& joints, sensor_msgs::JointState* message);
/** As the robot's own branch has them: seven joints; the opening and both graspers. */
void fillRaven(Arm arm, const CrtkJoints& joints, sensor_msgs::JointState* message);
void fillRavenGrasp(Arm arm, const CrtkJoints& joints, sensor_msgs::JointState* message);

// In frame R, whose name is in the header already.
void fill(const CrtkFrame& frame, const Pose& X_BT, geometry_msgs::PoseStamped* message);
void fill(const CrtkFrame& frame, const Pose& X_BT, geometry_msgs::TransformStamped* message);
void fill(const CrtkFrame& frame, const Vector3& v_B, const Vector3& w_B, geometry_msgs::TwistStamped* message);
/** Row by row, rows 0 to 2 linear, 3 to 5 angular. */
void fill(const CrtkFrame& frame, const ServoJacobian& J_B, std_msgs::Float64MultiArray* message);

}  // namespace raven2_trainer::ros_bridge
