#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <sensor_msgs/JointState.h>

#include <array>
#include <optional>
#include <string>

#include "raven2_trainer/control/servo.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "ros/crtk/crtk_frames.h"

// The command in a CRTK client's message. Lengths, names, frames and numbers are checked here. Whether the arms may do
// it is checked where they are moved (ServoRefusal).

namespace raven2_trainer::ros_bridge {

/** [-] Of a quaternion's length from 1, as ITP's receivers allow (sources.md 2.2). */
constexpr double kUnitTolerance = 0.02;

/** Names of ServoJoints in CRTK's joint states. */
constexpr std::array<const char*, kServoJointCount> kServoJointNames{"shoulder",      "elbow", "insertion",
                                                                     "tool_rotation", "wrist", "jaw_midline"};
constexpr const char* kJawName = "jaw";

/** A command, or a sentence with the reason for its refusal. */
struct CrtkAsked {
  std::optional<ServoCommand> command;
  std::string refusal;
  std::optional<ServoCommand> jaw{};  ///< what the same message asks of the jaws

  /** It set something that is looked at where messages are read. */
  bool isNothing() const { return !command && refusal.empty(); }
};

CrtkAsked readState(Arm arm, const std::string& word);
/** kHold, kFree. */
CrtkAsked readPlain(Arm arm, ServoKind kind);
/** kServoJoints, kServoJointsBy, kMoveJoints, kMoveJointsBy: positions. kServoRates: velocities. kServoForces: efforts.
 */
CrtkAsked readJoints(Arm arm, ServoKind kind, const sensor_msgs::JointState& message);
/** kServoJaw, kServoJawBy, kMoveJaw, kMoveJawBy: a position. kServoJawForce: an effort. */
CrtkAsked readJaw(Arm arm, ServoKind kind, const sensor_msgs::JointState& message);
/** kServoPose, kServoPoseBy, kMovePose. */
CrtkAsked readPose(Arm arm, ServoKind kind, const CrtkFrame& frame, const geometry_msgs::PoseStamped& message);
/** kServoTwist. */
CrtkAsked readTwist(Arm arm, const CrtkFrame& frame, const geometry_msgs::TwistStamped& message);

/** kServoWrench, at the tip; of `kOrigin` the torque is about the origin of the frame, of `kBody` all is along the
 * tip's own axes, whose frame has no name. */
CrtkAsked readWrench(Arm arm, const CrtkFrame& frame, WrenchFrame where, const geometry_msgs::WrenchStamped& message);
/** kRatio, kGravity, kTool. */
CrtkAsked readNumber(Arm arm, ServoKind kind, double number);

/** The same poses as the robot's own branch has them. */
CrtkAsked readTransform(Arm arm,
                        ServoKind kind,
                        const CrtkFrame& frame,
                        const geometry_msgs::TransformStamped& message);
/** Its servo_jp, servo_jr and servo_jv: seven numbers, shoulder to wrist and both graspers, or one, the shoulder's
 * alone (there servo_jp sends the other joints to 0 then; here they stay). Numbers of servo_jr and servo_jv after the
 * seventh
 * are ignored, as there; so are names. Of servo_jv the graspers turn the mid-line alone. Neither arm nor
 * jaws are asked for anything if one is to be beyond its limits; jaws are not if a step leaves them as they are, which
 * would end their move. */
CrtkAsked readRavenJoints(const ArmGeometry& geometry, Arm arm, ServoKind kind, const sensor_msgs::JointState& message);
/** Of its graspers: one number, the opening, or seven or more, of which the first is that. Names are ignored, as there:
 * crtk-cpp names the joint `grasp`. */
CrtkAsked readRavenJaw(Arm arm, ServoKind kind, const sensor_msgs::JointState& message);
/** Its servo_cv: translation in m/s; the rotation is that of one second, up to a whole revolution. */
CrtkAsked readTransformTwist(Arm arm, const CrtkFrame& frame, const geometry_msgs::TransformStamped& message);

}  // namespace raven2_trainer::ros_bridge
