#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64MultiArray.h>

#include "raven2_trainer/control/servo.h"
#include "raven2_trainer/control/servo_forces.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "ros/crtk/crtk_frames.h"

// States of an arm in CRTK's messages. Messages are filled in place, so that they keep their memory.

namespace raven2_trainer::ros_bridge {

using control::ServoJacobian;

/** An arm's joints and its jaws' opening. */
struct CrtkJoints {
  ServoJoints q{}, dq{}, effort{};         ///< [rad; m], [rad/s; m/s], [Nm; N] the model's
  double jaw{}, jaw_rate{}, jaw_effort{};  ///< [rad], [rad/s], [Nm]
};

/** An arm as measured; all follows from its joints. */
struct CrtkMeasured : CrtkJoints {
  Pose X_BT{};                               ///< of the tool tip, by forward kinematics of q
  Vector3 v_B{Vector3::Zero()};              ///< [m/s] of it, J dq
  Vector3 w_B{Vector3::Zero()};              ///< [rad/s]
  ServoJacobian J_B{ServoJacobian::Zero()};  ///< columns ServoJoints; rows 0 to 2 linear, 3 to 5 angular, both in B
};

/** @param[in] q, dq [rad; m], per second. @param[in] tau [Nm; N] the model's. */
CrtkMeasured measured(const ArmGeometry& geometry,
                      Arm arm,
                      const JointArray& q,
                      const JointArray& dq,
                      const JointArray& tau) noexcept;

/** Of what is rigidly the tip's and at the origin of R just then: rows 0 to 2 [m/s], in B still. */
ServoJacobian atOrigin(const CrtkFrame& frame, const CrtkMeasured& measured);

/** The source of the joints in measured_* of an arm's device. */
enum class MeasuredFrom : std::uint8_t {
  kModel,  ///< no robot has been there yet
  kRobot,  ///< it is there, and its state fresh
  kStale,  ///< its last state, repeated with the stamp that it came with
  kNone,   ///< that is too long ago: nothing is reported
};

/** Keeps to one source: after a robot was there, the model's joints are no longer published, and the jaws' neither. */
class MeasuredSource {
 public:
  static constexpr Tick kRepeated = 500;  ///< [1 ms] so long a state that grows stale is reported again

  /** Of a cycle; not twice of one tick. @param[in] stamp of the cycle. */
  void take(Arm arm, const ModelState& model, const RobotState& robot, const ros::Time& stamp) noexcept;

  MeasuredFrom from() const noexcept { return from_; }
  const JointArray& q() const noexcept { return q_; }    ///< [rad; m]
  const JointArray& dq() const noexcept { return dq_; }  ///< [rad/s; m/s]
  const ros::Time& stamp() const noexcept { return stamp_; }
  /** [1 ms] since the robot's state was fresh. */
  Tick age() const noexcept { return age_; }

 private:
  MeasuredFrom from_{MeasuredFrom::kModel};
  JointArray q_{}, dq_{};
  ros::Time stamp_;
  Tick fresh_tick_{-1}, age_{0};
};

/** How fast the set point moves, by two of its states. */
class SetpointRate {
 public:
  /** [rad/s; m/s] since the set point of an earlier tick; 0 at first, after a gap and after a leap back. */
  const ServoJoints& of(Tick tick, const ServoJoints& q, double jaw) noexcept;
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
