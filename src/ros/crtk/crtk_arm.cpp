#include "ros/crtk/crtk_arm.h"

#include <std_msgs/Bool.h>
#include <std_msgs/Float64.h>

#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** In the dialect of the robot's own branch measured_cp is in its turned base, setpoint_cp in the base itself. */
CrtkStyle styleOf(const CrtkConfig& config, Arm arm, const Pose& X_WB, const std::string& above) {
  CrtkStyle style;
  style.arm = arm;
  style.is_raven = config.dialect == CrtkDialect::kRaven;
  style.is_transform = config.dialect == CrtkDialect::kTransform;
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
      twist_timeout_(twistTimeout(config)),
      voice_(*voice),
      contacts_(body_names),
      own_(node, styleOf(config, arm, X_WB, "")),
      model_(node, styleOf(config, arm, X_WB, "model/")),
      state_(node, at(config.names, arm) + "/operating_state", config) {
  const std::string& name = at(config.names, arm);
  is_valid_ = node->advertise<std_msgs::Bool>(name + "/is_valid", 1, /*latch=*/true);
  ratio_ = node->advertise<std_msgs::Float64>(name + "/trajectory_j/ratio", 1, /*latch=*/true);
  timeout_ = node->advertise<std_msgs::Float64>(name + "/twist_timeout", 1, /*latch=*/true);
  publishLatched<std_msgs::Float64>(timeout_, twist_timeout_);
}

void CrtkArm::publish(const CrtkCycle& cycle) {
  publishState(cycle);
  reportAlone(cycle.servo);
  reportRunOut(at(cycle.servo.arms, arm_));
  reportEnded(at(cycle.servo.arms, arm_));
  publishRatio(at(cycle.servo.arms, arm_).ratio);
  publishOwn(cycle);
  publishModel(cycle);
}

void CrtkArm::publishState(const CrtkCycle& cycle) {
  const ServoState& servo = cycle.servo;
  const ServoArmState& arm = at(servo.arms, arm_);
  if (state_.publish(servo, arm.is_busy != 0, arm.moves, cycle.stamp))
    voice_.say(level(servo.state), sentence(servo.state));
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

/** Once a second: a client may go on pushing. */
void CrtkArm::reportEnded(const ServoArmState& arm) {
  if (arm.ended == reported_ended_) return;
  reported_ended_ = arm.ended;
  voice_.complain(CrtkLevel::kWarning, "ended", kEndedSentence, net::monotonicNow());
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
