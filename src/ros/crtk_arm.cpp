#include "ros/crtk_arm.h"

#include <ros/advertise_options.h>

#include "ros/name_of.h"
#include "ros/topic.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** With the name that the clients of a dialect know the type by; fields and check sum are the same. */
ros::Publisher advertiseState(ros::NodeHandle* node, const std::string& topic, CrtkDialect dialect) {
  ros::AdvertiseOptions options;
  options.init<crtk::OperatingState>(topic, 1);
  options.latch = true;
  if (dialect == CrtkDialect::kRaven) options.datatype = crtk::kRetiredOperatingStateType;
  return node->advertise(options);
}

bool differs(const crtk::OperatingState& a, const crtk::OperatingState& b) {
  return a.state != b.state || a.is_homed != b.is_homed || a.is_busy != b.is_busy;
}

template <typename Message>
void setHeader(const std::string& frame, const ros::Time& stamp, Message* message) {
  message->header.frame_id = frame;
  message->header.stamp = stamp;
}

/** In the dialect of the robot's own branch measured_cp is in its turned base, setpoint_cp in the base itself. */
CrtkFrame measuredFrame(CrtkDialect dialect, Arm arm, const Pose& X_WB) {
  return dialect == CrtkDialect::kRaven ? ravenFrame(arm) : worldFrame(X_WB);
}
CrtkFrame setpointFrame(CrtkDialect dialect, Arm arm, const Pose& X_WB) {
  return dialect == CrtkDialect::kRaven ? baseFrame(arm) : worldFrame(X_WB);
}

}  // namespace

CrtkArm::CrtkArm(ros::NodeHandle* node,
                 Arm arm,
                 const TrainerConfig& config,
                 const Pose& X_WB,
                 const std::vector<std::string>& body_names,
                 CrtkVoice* voice)
    : arm_(arm),
      geometry_(config.arms.geometry),
      X_WB_(X_WB),
      name_(at(config.crtk.names, arm)),
      state_period_(config.crtk.state_period),
      is_raven_(config.crtk.dialect == CrtkDialect::kRaven),
      voice_(*voice),
      contacts_(body_names),
      operating_state_(advertiseState(node, name_ + "/operating_state", config.crtk.dialect)) {
  const CrtkDialect dialect = config.crtk.dialect;
  const CrtkFrame world = worldFrame(X_WB), base = baseFrame(arm);
  measured_js_ = jointTopic(node, name_ + "/measured_js");
  setpoint_js_ = jointTopic(node, name_ + "/setpoint_js");
  jaw_measured_js_ = jointTopic(node, jawNamespace(config.crtk, arm) + "/measured_js");
  jaw_setpoint_js_ = jointTopic(node, jawNamespace(config.crtk, arm) + "/setpoint_js");
  measured_cp_ = poseTopic(node, "measured_cp", measuredFrame(dialect, arm, X_WB), is_raven_);
  setpoint_cp_ = poseTopic(node, "setpoint_cp", setpointFrame(dialect, arm, X_WB), is_raven_);
  goal_cp_ = poseTopic(node, "goal_cp", world, false);
  local_measured_cp_ = poseTopic(node, "local/measured_cp", base, false);
  local_setpoint_cp_ = poseTopic(node, "local/setpoint_cp", base, false);
  local_goal_cp_ = poseTopic(node, "local/goal_cp", base, false);
  measured_cv_ = twistTopic(node, "measured_cv", world);
  local_measured_cv_ = twistTopic(node, "local/measured_cv", base);
  jacobian_ = jacobianTopic(node, "jacobian", world);
  local_jacobian_ = jacobianTopic(node, "local/jacobian", base);
  measured_cf_ = node->advertise<geometry_msgs::WrenchStamped>(name_ + "/measured_cf", kQueue);
}

CrtkArm::PoseTopic CrtkArm::poseTopic(ros::NodeHandle* node,
                                      const std::string& name,
                                      const CrtkFrame& frame,
                                      bool is_transform) const {
  PoseTopic topic;
  topic.frame = frame;
  topic.is_transform = is_transform;
  topic.publisher = is_transform ? node->advertise<geometry_msgs::TransformStamped>(name_ + "/" + name, kQueue)
                                 : node->advertise<geometry_msgs::PoseStamped>(name_ + "/" + name, kQueue);
  return topic;
}

CrtkArm::TwistTopic CrtkArm::twistTopic(ros::NodeHandle* node, const std::string& name, const CrtkFrame& frame) const {
  return {node->advertise<geometry_msgs::TwistStamped>(name_ + "/" + name, kQueue), frame, {}};
}

CrtkArm::JacobianTopic CrtkArm::jacobianTopic(ros::NodeHandle* node,
                                              const std::string& name,
                                              const CrtkFrame& frame) const {
  return {node->advertise<std_msgs::Float64MultiArray>(name_ + "/" + name, kQueue), frame, {}};
}

CrtkArm::JointTopic CrtkArm::jointTopic(ros::NodeHandle* node, const std::string& topic) {
  return {node->advertise<sensor_msgs::JointState>(topic, kQueue), {}};
}

void CrtkArm::publish(const CrtkCycle& cycle) {
  publishState(cycle);
  tellAlone(cycle.servo);
  publishMeasured(cycle);
  publishSetpoint(cycle);
}

void CrtkArm::publishState(const CrtkCycle& cycle) {
  const ServoState& servo = cycle.servo;
  crtk::OperatingState now;
  now.header.stamp = cycle.stamp;
  now.state = nameOf(kOperatingStateNames, servo.state);
  now.is_homed = servo.is_homed;
  now.is_busy = at(servo.arms, arm_).is_busy;
  const bool is_new = !has_told_ || differs(now, told_);
  const double age = static_cast<double>(servo.tick - told_tick_) * kTickSeconds;
  if (!is_new && age >= 0.0 && age < state_period_) return;
  operating_state_.publish(now);
  if (has_told_ && now.state != told_.state) voice_.say(level(servo.state), sentence(servo.state));
  told_ = now;
  told_tick_ = servo.tick;
  has_told_ = true;
}

void CrtkArm::tellAlone(const ServoState& servo) {
  const bool is_alone = servo.alone != 0;
  if (is_alone && !was_alone_) voice_.say(CrtkLevel::kWarning, kAloneSentence);
  was_alone_ = is_alone;
}

void CrtkArm::publishMeasured(const CrtkCycle& cycle) {
  const CrtkMeasured m = measured(geometry_, arm_, cycle.model, cycle.robot);
  publishJoints(m, cycle.stamp, &measured_js_, &jaw_measured_js_);
  for (PoseTopic* topic : {&measured_cp_, &local_measured_cp_})
    publishPose(m.X_BT, cycle.stamp, topic);
  for (TwistTopic* topic : {&measured_cv_, &local_measured_cv_}) {
    if (topic->publisher.getNumSubscribers() == 0) continue;
    setHeader(topic->frame.name, cycle.stamp, &topic->message);
    fill(topic->frame, m.v_B, m.w_B, &topic->message);
    topic->publisher.publish(topic->message);
  }
  for (JacobianTopic* topic : {&jacobian_, &local_jacobian_}) {
    if (topic->publisher.getNumSubscribers() == 0) continue;
    fill(topic->frame, m.J_B, &topic->message);
    topic->publisher.publish(topic->message);
  }
  if (wantsContacts()) publishForce(cycle, m.X_BT);
}

void CrtkArm::publishForce(const CrtkCycle& cycle, const Pose& X_BT) {
  setHeader("world", cycle.stamp, &force_);
  fill(contacts_.on(arm_, cycle.contacts, X_WB_ * X_BT.p), &force_);
  measured_cf_.publish(force_);
}

void CrtkArm::publishSetpoint(const CrtkCycle& cycle) {
  const ServoArmState& arm = at(cycle.servo.arms, arm_);
  const JointArray& tau = at(cycle.model.arms, arm_).tau;
  CrtkJoints joints;
  joints.q = arm.setpoint_q;
  joints.dq = setpoint_rate_.of(cycle.servo.tick, arm);
  joints.effort = servoEfforts(tau);
  joints.jaw = arm.setpoint_jaw;
  joints.jaw_rate = setpoint_rate_.jaw();
  joints.jaw_effort = jawEffort(tau);
  publishJoints(joints, cycle.stamp, &setpoint_js_, &jaw_setpoint_js_);
  for (PoseTopic* topic : {&setpoint_cp_, &local_setpoint_cp_})
    publishPose(toEigen(arm.setpoint_B), cycle.stamp, topic);
  for (PoseTopic* topic : {&goal_cp_, &local_goal_cp_})
    publishPose(toEigen(arm.goal_B), cycle.stamp, topic);
}

void CrtkArm::publishPose(const Pose& X_BT, const ros::Time& stamp, PoseTopic* topic) {
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

void CrtkArm::publishJoints(const CrtkJoints& joints, const ros::Time& stamp, JointTopic* all, JointTopic* jaw) {
  if (all->publisher.getNumSubscribers() > 0) {
    is_raven_ ? fillRaven(arm_, joints, &all->message) : fill(joints, &all->message);
    setHeader("world", stamp, &all->message);
    all->publisher.publish(all->message);
  }
  if (jaw->publisher.getNumSubscribers() > 0) {
    is_raven_ ? fillRavenGrasp(arm_, joints, &jaw->message) : fillJaw(joints, &jaw->message);
    setHeader("world", stamp, &jaw->message);
    jaw->publisher.publish(jaw->message);
  }
}

}  // namespace raven2_trainer::ros_bridge
