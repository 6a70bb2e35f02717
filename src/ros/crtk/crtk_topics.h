#pragma once

#include <geometry_msgs/WrenchStamped.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

#include "ros/crtk/crtk_states.h"
#include "ros/crtk/crtk_wrench.h"

namespace raven2_trainer::ros_bridge {

/** Message types and frames of a device's states. */
struct CrtkStyle {
  Arm arm{Arm::kGold};
  bool is_raven{};        ///< the robot's own dialect
  bool is_transform{};    ///< dialect `transform`: all poses are TransformStamped
  std::string name;       ///< namespace of the device
  std::string jaw;        ///< of its jaws
  Pose X_WB{};            ///< the arm's base in `world`
  CrtkFrame measured_cp;  ///< of measured_cp
  CrtkFrame setpoint_cp;  ///< of setpoint_cp
};

/** The topics with measured and commanded positions of a device; each only while it has a subscriber. One thread.
 */
class CrtkTopics {
 public:
  CrtkTopics(ros::NodeHandle* node, const CrtkStyle& style);

  bool wantsForce() const;
  /** @param[in] contact about the tip, in W; looked at only if wantsForce(). */
  void publishMeasured(const CrtkMeasured& measured, const ArmWrench& contact, const ros::Time& stamp);
  void publishSetpoint(const CrtkJoints& joints, const Pose& setpoint_BT, const Pose& goal_BT, const ros::Time& stamp);

 private:
  /** A topic of poses in a frame: PoseStamped, or TransformStamped in the robot's own dialect. */
  struct PoseTopic {
    ros::Publisher publisher;
    CrtkFrame frame;
    geometry_msgs::PoseStamped pose;
    geometry_msgs::TransformStamped transform;
    bool is_transform{false};
  };
  /** Any other. */
  template <typename Message>
  struct Topic {
    ros::Publisher publisher;
    Message message;
    bool isHeard() const { return publisher.getNumSubscribers() > 0; }
  };
  using JointTopic = Topic<sensor_msgs::JointState>;
  using TwistTopic = Topic<geometry_msgs::TwistStamped>;
  using WrenchTopic = Topic<geometry_msgs::WrenchStamped>;
  using JacobianTopic = Topic<std_msgs::Float64MultiArray>;

  PoseTopic poseTopic(ros::NodeHandle* node, const std::string& name, const CrtkFrame& frame, bool is_transform) const;
  template <typename Message>
  Topic<Message> topic(ros::NodeHandle* node, const std::string& name) const;

  void publishJoints(const CrtkJoints& joints, const ros::Time& stamp, JointTopic* all, JointTopic* jaw);
  void publishJacobians(const CrtkMeasured& measured);
  void publishForces(const Pose& X_BT, const ArmWrench& contact, const ros::Time& stamp);
  static void publishPose(const Pose& X_BT, const ros::Time& stamp, PoseTopic* topic);

  const CrtkStyle style_;
  const CrtkFrame world_, base_;
  JointTopic measured_js_, setpoint_js_, jaw_measured_js_, jaw_setpoint_js_;
  PoseTopic measured_cp_, setpoint_cp_, goal_cp_, local_measured_cp_, local_setpoint_cp_, local_goal_cp_;
  TwistTopic measured_cv_, local_measured_cv_;
  JacobianTopic jacobian_, local_jacobian_, body_jacobian_, spatial_jacobian_;
  WrenchTopic measured_cf_, body_measured_cf_, spatial_measured_cf_;
};

}  // namespace raven2_trainer::ros_bridge
