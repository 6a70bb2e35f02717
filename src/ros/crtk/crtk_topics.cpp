#include "ros/crtk/crtk_topics.h"

#include "ros/node/topic.h"

namespace raven2_trainer::ros_bridge {
namespace {

template <typename Message>
void setHeader(const std::string& frame, const ros::Time& stamp, Message* message) {
  message->header.frame_id = frame;
  message->header.stamp = stamp;
}

/** The tip's own axes, at the tip: those of measured_cp; no frame of /tf. */
CrtkFrame bodyFrame(const Pose& X_BT) {
  return {"", {}, X_BT};
}

}  // namespace

CrtkTopics::CrtkTopics(ros::NodeHandle* node, const CrtkStyle& style)
    : style_(style),
      world_(worldFrame(style.X_WB)),
      base_(baseFrame(style.arm)),
      measured_js_(topic<sensor_msgs::JointState>(node, "measured_js")),
      setpoint_js_(topic<sensor_msgs::JointState>(node, "setpoint_js")),
      jaw_measured_js_{node->advertise<sensor_msgs::JointState>(style.jaw + "/measured_js", kQueue), {}},
      jaw_setpoint_js_{node->advertise<sensor_msgs::JointState>(style.jaw + "/setpoint_js", kQueue), {}},
      measured_cp_(poseTopic(node, "measured_cp", style.measured_cp, style.is_raven || style.is_transform)),
      setpoint_cp_(poseTopic(node, "setpoint_cp", style.setpoint_cp, style.is_raven || style.is_transform)),
      goal_cp_(poseTopic(node, "goal_cp", world_, style.is_transform)),
      local_measured_cp_(poseTopic(node, "local/measured_cp", base_, style.is_transform)),
      local_setpoint_cp_(poseTopic(node, "local/setpoint_cp", base_, style.is_transform)),
      local_goal_cp_(poseTopic(node, "local/goal_cp", base_, style.is_transform)),
      measured_cv_(topic<geometry_msgs::TwistStamped>(node, "measured_cv")),
      local_measured_cv_(topic<geometry_msgs::TwistStamped>(node, "local/measured_cv")),
      jacobian_(topic<std_msgs::Float64MultiArray>(node, "jacobian")),
      local_jacobian_(topic<std_msgs::Float64MultiArray>(node, "local/jacobian")),
      body_jacobian_(topic<std_msgs::Float64MultiArray>(node, "body/jacobian")),
      spatial_jacobian_(topic<std_msgs::Float64MultiArray>(node, "spatial/jacobian")),
      measured_cf_(topic<geometry_msgs::WrenchStamped>(node, "measured_cf")),
      body_measured_cf_(topic<geometry_msgs::WrenchStamped>(node, "body/measured_cf")),
      spatial_measured_cf_(topic<geometry_msgs::WrenchStamped>(node, "spatial/measured_cf")) {}

CrtkTopics::PoseTopic CrtkTopics::poseTopic(ros::NodeHandle* node,
                                            const std::string& name,
                                            const CrtkFrame& frame,
                                            bool is_transform) const {
  PoseTopic topic;
  topic.frame = frame;
  topic.is_transform = is_transform;
  const std::string path = style_.name + "/" + name;
  topic.publisher = is_transform ? node->advertise<geometry_msgs::TransformStamped>(path, kQueue)
                                 : node->advertise<geometry_msgs::PoseStamped>(path, kQueue);
  return topic;
}

template <typename Message>
CrtkTopics::Topic<Message> CrtkTopics::topic(ros::NodeHandle* node, const std::string& name) const {
  return {node->advertise<Message>(style_.name + "/" + name, kQueue), {}};
}

bool CrtkTopics::wantsForce() const {
  return measured_cf_.isHeard() || body_measured_cf_.isHeard() || spatial_measured_cf_.isHeard();
}

void CrtkTopics::publishMeasured(const CrtkMeasured& measured, const ArmWrench& contact, const ros::Time& stamp) {
  publishJoints(measured, stamp, &measured_js_, &jaw_measured_js_);
  for (PoseTopic* topic : {&measured_cp_, &local_measured_cp_})
    publishPose(measured.X_BT, stamp, topic);
  const auto publishTwist = [&](const CrtkFrame& frame, TwistTopic* topic) {
    if (!topic->isHeard()) return;
    setHeader(frame.name, stamp, &topic->message);
    fill(frame, measured.v_B, measured.w_B, &topic->message);
    topic->publisher.publish(topic->message);
  };
  publishTwist(world_, &measured_cv_);
  publishTwist(base_, &local_measured_cv_);
  publishJacobians(measured);
  if (wantsForce()) publishForces(measured.X_BT, contact, stamp);
}

void CrtkTopics::publishJacobians(const CrtkMeasured& measured) {
  const auto publish = [](const CrtkFrame& frame, const ServoJacobian& J_B, JacobianTopic* topic) {
    if (!topic->isHeard()) return;
    fill(frame, J_B, &topic->message);
    topic->publisher.publish(topic->message);
  };
  publish(world_, measured.J_B, &jacobian_);
  publish(base_, measured.J_B, &local_jacobian_);
  publish(bodyFrame(measured.X_BT), measured.J_B, &body_jacobian_);
  publish(world_, atOrigin(world_, measured), &spatial_jacobian_);
}

void CrtkTopics::publishForces(const Pose& X_BT, const ArmWrench& contact, const ros::Time& stamp) {
  const Pose X_WT = style_.X_WB * X_BT;
  const auto publish = [&](const std::string& frame, const ArmWrench& wrench, WrenchTopic* topic) {
    if (!topic->isHeard()) return;
    setHeader(frame, stamp, &topic->message);
    fill(wrench, &topic->message);
    topic->publisher.publish(topic->message);
  };
  publish("world", contact, &measured_cf_);
  publish(bodyFrame(X_BT).name, alongTip(contact, X_WT), &body_measured_cf_);
  publish("world", aboutOrigin(contact, X_WT), &spatial_measured_cf_);
}

void CrtkTopics::publishSetpoint(const CrtkJoints& joints,
                                 const Pose& setpoint_BT,
                                 const Pose& goal_BT,
                                 const ros::Time& stamp) {
  publishJoints(joints, stamp, &setpoint_js_, &jaw_setpoint_js_);
  for (PoseTopic* topic : {&setpoint_cp_, &local_setpoint_cp_})
    publishPose(setpoint_BT, stamp, topic);
  for (PoseTopic* topic : {&goal_cp_, &local_goal_cp_})
    publishPose(goal_BT, stamp, topic);
}

void CrtkTopics::publishPose(const Pose& X_BT, const ros::Time& stamp, PoseTopic* topic) {
  if (topic->publisher.getNumSubscribers() == 0) return;
  if (topic->is_transform) {
    setHeader(topic->frame.name, stamp, &topic->transform);
    fill(topic->frame, X_BT, &topic->transform);
    topic->publisher.publish(topic->transform);
  } else {
    setHeader(topic->frame.name, stamp, &topic->pose);
    fill(topic->frame, X_BT, &topic->pose);
    topic->publisher.publish(topic->pose);
  }
}

void CrtkTopics::publishJoints(const CrtkJoints& joints, const ros::Time& stamp, JointTopic* all, JointTopic* jaw) {
  if (all->isHeard()) {
    style_.is_raven ? fillRaven(style_.arm, joints, &all->message) : fill(joints, &all->message);
    setHeader("world", stamp, &all->message);
    all->publisher.publish(all->message);
  }
  if (jaw->isHeard()) {
    style_.is_raven ? fillRavenGrasp(style_.arm, joints, &jaw->message) : fillJaw(joints, &jaw->message);
    setHeader("world", stamp, &jaw->message);
    jaw->publisher.publish(jaw->message);
  }
}

}  // namespace raven2_trainer::ros_bridge
