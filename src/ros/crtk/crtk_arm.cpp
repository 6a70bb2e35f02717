#include "ros/crtk/crtk_arm.h"

#include <ros/advertise_options.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Float64.h>

#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/net/clock.h"
#include "ros/node/name_of.h"

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

/** In the dialect of the robot's own branch measured_cp is in its turned base, setpoint_cp in the base itself. */
CrtkStyle styleOf(const CrtkConfig& config, Arm arm, const Pose& X_WB, const std::string& above) {
  CrtkStyle style;
  style.arm = arm;
  style.is_raven = config.dialect == CrtkDialect::kRaven;
  style.name = above + at(config.names, arm);
  style.jaw = above + jawNamespace(config, arm);
  style.X_WB = X_WB;
  style.measured_cp = style.is_raven ? ravenFrame(arm) : worldFrame(X_WB);
  style.setpoint_cp = style.is_raven ? baseFrame(arm) : worldFrame(X_WB);
  return style;
}

template <typename Message, typename Value>
void publishLatched(const ros::Publisher& publisher, Value value) {
  Message message;
  message.data = value;
  publisher.publish(message);
}

}  // namespace

CrtkArm::CrtkArm(ros::NodeHandle* node,
                 Arm arm,
                 const CrtkConfig& config,
                 const ArmGeometry& geometry,
                 const Pose& X_WB,
                 const std::vector<std::string>& body_names,
                 CrtkVoice* voice)
    : arm_(arm),
      geometry_(geometry),
      X_WB_(X_WB),
      state_period_(config.state_period),
      twist_timeout_(twistTimeout(config)),
      voice_(*voice),
      contacts_(body_names),
      own_(node, styleOf(config, arm, X_WB, "")),
      model_(node, styleOf(config, arm, X_WB, "model/")) {
  const std::string& name = at(config.names, arm);
  operating_state_ = advertiseState(node, name + "/operating_state", config.dialect);
  is_valid_ = node->advertise<std_msgs::Bool>(name + "/is_valid", 1, /*latch=*/true);
  ratio_ = node->advertise<std_msgs::Float64>(name + "/trajectory_j/ratio", 1, /*latch=*/true);
  timeout_ = node->advertise<std_msgs::Float64>(name + "/twist_timeout", 1, /*latch=*/true);
  publishLatched<std_msgs::Float64>(timeout_, twist_timeout_);
}

void CrtkArm::publish(const CrtkCycle& cycle) {
  publishState(cycle);
  reportAlone(cycle.servo);
  reportRunOut(at(cycle.servo.arms, arm_));
  publishRatio(at(cycle.servo.arms, arm_).ratio);
  publishOwn(cycle);
  publishModel(cycle);
}

void CrtkArm::publishState(const CrtkCycle& cycle) {
  const ServoState& servo = cycle.servo;
  crtk::OperatingState now;
  now.header.stamp = cycle.stamp;
  now.state = nameOf(kOperatingStateNames, servo.state);
  now.is_homed = servo.is_homed;
  now.is_busy = at(servo.arms, arm_).is_busy;
  const bool is_new = !has_published_ || differs(now, published_);
  const double age = static_cast<double>(servo.tick - last_tick_published_) * kTickSeconds;
  if (!is_new && age >= 0.0 && age < state_period_) return;
  operating_state_.publish(now);
  if (has_published_ && now.state != published_.state) voice_.say(level(servo.state), sentence(servo.state));
  published_ = now;
  last_tick_published_ = servo.tick;
  has_published_ = true;
}

void CrtkArm::reportAlone(const ServoState& servo) {
  const bool is_alone = servo.alone != 0;
  if (is_alone && !was_alone_) voice_.say(CrtkLevel::kWarning, kAloneSentence);
  was_alone_ = is_alone;
}

void CrtkArm::reportRunOut(const ServoArmState& arm) {
  if (arm.run_out == reported_run_out_) return;
  reported_run_out_ = arm.run_out;
  voice_.say(CrtkLevel::kWarning, runOutSentence(twist_timeout_));
}

void CrtkArm::publishRatio(double ratio) {
  if (ratio == published_ratio_) return;
  published_ratio_ = ratio;
  publishLatched<std_msgs::Float64>(ratio_, ratio);
}

/** At each change what measured_* is worth, and why, should it be worth less. */
void CrtkArm::publishSource() {
  const MeasuredFrom from = source_.from();
  if (has_published_source_ && from == published_from_) return;
  publishLatched<std_msgs::Bool>(is_valid_, static_cast<std::uint8_t>(from == MeasuredFrom::kRobot));
  const std::string why = sentence(from, source_.age());
  if (!why.empty())
    voice_.complain(level(from), "measured/" + std::to_string(static_cast<int>(from)), why, net::monotonicNow());
  published_from_ = from;
  has_published_source_ = true;
}

ArmWrench CrtkArm::contactOn(const CrtkCycle& cycle, const Pose& X_BT) const {
  return contacts_.on(arm_, cycle.contacts, X_WB_ * X_BT.p);
}

/** Publishes set points always, measurements while they are known. */
void CrtkArm::publishOwn(const CrtkCycle& cycle) {
  const JointArray& tau = at(cycle.model.arms, arm_).tau;
  source_.take(arm_, cycle.model, cycle.robot, cycle.stamp);
  publishSource();
  if (source_.from() != MeasuredFrom::kNone) {
    const CrtkMeasured m = measured(geometry_, arm_, source_.q(), source_.dq(), tau);
    own_.publishMeasured(m, contactOn(cycle, m.X_BT), source_.stamp());
  }
  const ServoArmState& arm = at(cycle.servo.arms, arm_);
  CrtkJoints joints;
  joints.q = arm.setpoint_q;
  joints.dq = setpoint_rate_.of(cycle.servo.tick, arm.setpoint_q, arm.setpoint_jaw);
  joints.effort = control::servoForces(tau);
  joints.jaw = arm.setpoint_jaw;
  joints.jaw_rate = setpoint_rate_.jaw();
  joints.jaw_effort = control::jawForce(tau);
  own_.publishSetpoint(joints, toEigen(arm.setpoint_B), toEigen(arm.goal_B), cycle.stamp);
}

void CrtkArm::publishModel(const CrtkCycle& cycle) {
  const ArmState& arm = at(cycle.model.arms, arm_);
  const CrtkMeasured m = measured(geometry_, arm_, arm.q, arm.dq, arm.tau);
  model_.publishMeasured(m, contactOn(cycle, m.X_BT), cycle.stamp);
  CrtkJoints joints = m;
  joints.q = control::servoJoints(arm.q_d);
  joints.jaw = kinematics::jawOpening(arm.q_d);
  joints.dq = model_rate_.of(cycle.model.tick, joints.q, joints.jaw);
  joints.jaw_rate = model_rate_.jaw();
  const Pose wanted = kinematics::forward(geometry_, arm_, arm.q_d);
  model_.publishSetpoint(joints, wanted, wanted, cycle.stamp);
}

}  // namespace raven2_trainer::ros_bridge
