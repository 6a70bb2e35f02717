#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>
#include <vector>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "ros/crtk_messages.h"
#include "ros/crtk_states.h"
#include "ros/crtk_voice.h"
#include "ros/crtk_wrench.h"

namespace raven2_trainer::ros_bridge {

/** What one cycle tells: set point and model of one tick, the newest of the rest. */
struct CrtkCycle {
  ServoState servo{};
  ModelState model{};
  RobotState robot{};
  ContactList contacts{};
  ros::Time stamp;
};

/** Publishes the states of one arm: its operating state, latched, and while somebody listens what is measured, where it
 *  is to be and its Jacobian. One thread. */
class CrtkArm {
 public:
  /** @param[in] config, voice outlive this. @param[in] body_names by the numbers of contacts. */
  CrtkArm(ros::NodeHandle* node,
          Arm arm,
          const TrainerConfig& config,
          const Pose& X_WB,
          const std::vector<std::string>& body_names,
          CrtkVoice* voice);

  void publish(const CrtkCycle& cycle);
  bool wantsContacts() const { return measured_cf_.getNumSubscribers() > 0; }

 private:
  /** A topic of poses in a frame: PoseStamped, or TransformStamped in the robot's own dialect. */
  struct PoseTopic {
    ros::Publisher publisher;
    CrtkFrame frame;
    geometry_msgs::PoseStamped pose;
    geometry_msgs::TransformStamped transform;
    bool is_transform{false};
  };
  struct TwistTopic {
    ros::Publisher publisher;
    CrtkFrame frame;
    geometry_msgs::TwistStamped message;
  };
  struct JacobianTopic {
    ros::Publisher publisher;
    CrtkFrame frame;
    std_msgs::Float64MultiArray message;
  };
  struct JointTopic {
    ros::Publisher publisher;
    sensor_msgs::JointState message;
  };

  PoseTopic poseTopic(ros::NodeHandle* node, const std::string& name, const CrtkFrame& frame, bool is_transform) const;
  TwistTopic twistTopic(ros::NodeHandle* node, const std::string& name, const CrtkFrame& frame) const;
  JacobianTopic jacobianTopic(ros::NodeHandle* node, const std::string& name, const CrtkFrame& frame) const;
  static JointTopic jointTopic(ros::NodeHandle* node, const std::string& topic);

  void publishState(const CrtkCycle& cycle);
  void tellAlone(const ServoState& servo);
  void publishMeasured(const CrtkCycle& cycle);
  void publishJoints(const CrtkJoints& joints, const ros::Time& stamp, JointTopic* all, JointTopic* jaw);
  void publishForce(const CrtkCycle& cycle, const Pose& X_BT);
  void publishSetpoint(const CrtkCycle& cycle);
  static void publishPose(const Pose& X_BT, const ros::Time& stamp, PoseTopic* topic);

  const Arm arm_;
  const ArmGeometry geometry_;
  const Pose X_WB_;
  const std::string name_;
  const double state_period_;
  const bool is_raven_;  ///< the robot's own dialect
  CrtkVoice& voice_;
  ArmContacts contacts_;
  SetpointRate setpoint_rate_;

  ros::Publisher operating_state_;
  crtk::OperatingState told_;
  bool has_told_{false};
  bool was_alone_{false};
  Tick told_tick_{};

  JointTopic measured_js_, setpoint_js_, jaw_measured_js_, jaw_setpoint_js_;
  PoseTopic measured_cp_, setpoint_cp_, goal_cp_, local_measured_cp_, local_setpoint_cp_, local_goal_cp_;
  TwistTopic measured_cv_, local_measured_cv_;
  JacobianTopic jacobian_, local_jacobian_;
  ros::Publisher measured_cf_;
  geometry_msgs::WrenchStamped force_;
};

}  // namespace raven2_trainer::ros_bridge
