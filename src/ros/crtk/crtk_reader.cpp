#include "ros/crtk/crtk_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "ros/crtk/crtk_words.h"

namespace raven2_trainer::ros_bridge {
namespace {

std::string kindName(ServoKind kind) {
  return kServoKindNames[static_cast<std::size_t>(kind)];
}

CrtkAsked refuse(ServoKind kind, const std::string& why) {
  return {std::nullopt, kindName(kind) + ": " + why};
}

CrtkAsked notFinite(ServoKind kind) {
  return refuse(kind, "a number is NaN or infinite");
}

ServoCommand commandOf(Arm arm, ServoKind kind) {
  ServoCommand command;
  command.kind = kind;
  command.arm = arm;
  return command;
}

template <typename Names>
std::string listed(const Names& names) {
  std::string list;
  for (const auto& name : names)
    list += (list.empty() ? "" : ", ") + std::string(name);
  return list;
}

bool areFinite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

/** The numbers of a joint message for this kind of command. */
const std::vector<double>& numbersOf(ServoKind kind, const sensor_msgs::JointState& message) {
  const bool is_force = kind == ServoKind::kServoForces || kind == ServoKind::kServoJawForce;
  if (is_force) return message.effort;
  return kind == ServoKind::kServoRates ? message.velocity : message.position;
}
const char* numbersName(ServoKind kind) {
  const bool is_force = kind == ServoKind::kServoForces || kind == ServoKind::kServoJawForce;
  if (is_force) return " efforts";
  return kind == ServoKind::kServoRates ? " velocities" : " positions";
}

/** Why the joints of a message are not those that are wanted; empty: they are. */
template <typename Names>
std::string jointsFault(ServoKind kind, const sensor_msgs::JointState& message, const Names& wanted) {
  const std::string list = listed(wanted);
  const std::vector<double>& numbers = numbersOf(kind, message);
  if (numbers.size() != wanted.size())
    return std::to_string(numbers.size()) + numbersName(kind) + " where there are " + std::to_string(wanted.size()) +
           " joints: " + list;
  const bool is_named = !message.name.empty();
  if (is_named && !std::equal(message.name.begin(), message.name.end(), wanted.begin(), wanted.end()))
    return "the joints are named " + listed(message.name) + "; it is " + list + ", in this order, or no names";
  return areFinite(numbers) ? "" : "a number is NaN or infinite";
}

/** Why nothing can be said in a message's frame; empty: it can. */
std::string frameFault(const std_msgs::Header& header, const CrtkFrame& frame) {
  const std::string& name = header.frame_id;
  const auto& allowed = frame.allowed;
  if (name.empty() || std::find(allowed.begin(), allowed.end(), name) != allowed.end()) return "";
  const std::string known = allowed.empty() ? "no frame_id" : listed(allowed) + " or no frame_id";
  return "in frame \"" + name + "\"; it is " + known;
}

/** A client's rotation. */
struct Turn {
  Quaternion q{Quaternion::Identity()};
  std::string fault;
};

Turn turnOf(const geometry_msgs::Quaternion& r) {
  const Quaternion q(r.w, r.x, r.y, r.z);
  const double length = q.norm();
  if (!std::isfinite(length)) return {Quaternion::Identity(), "a number is NaN or infinite"};
  if (std::abs(length - 1.0) <= kUnitTolerance) return {q.normalized(), ""};
  char text[96];
  std::snprintf(text, sizeof text, "a quaternion of length %.3g is no orientation: it has length 1 (none: w = 1)",
                length);
  return {Quaternion::Identity(), text};
}

template <typename Xyz>
Vector3 vectorOf(const Xyz& v) {
  return {v.x, v.y, v.z};
}

CrtkAsked poseIn(Arm arm,
                 ServoKind kind,
                 const CrtkFrame& frame,
                 const std_msgs::Header& header,
                 const Vector3& p_R,
                 const geometry_msgs::Quaternion& rotation) {
  const std::string fault = frameFault(header, frame);
  if (!fault.empty()) return refuse(kind, fault);
  if (!p_R.allFinite()) return notFinite(kind);
  const Turn turn = turnOf(rotation);
  if (!turn.fault.empty()) return refuse(kind, turn.fault);
  ServoCommand command = commandOf(arm, kind);
  const Matrix3& R_BR = frame.X_BR.R;
  const Pose asked{turn.q.toRotationMatrix(), p_R};
  const bool is_by = kind == ServoKind::kServoPoseBy;
  command.pose_B = toArray(is_by ? Pose{R_BR * asked.R * R_BR.transpose(), R_BR * asked.p} : frame.X_BR * asked);
  return {command, ""};
}

CrtkAsked twistIn(Arm arm,
                  const CrtkFrame& frame,
                  const std_msgs::Header& header,
                  const Vector3& v_R,
                  const Vector3& w_R) {
  const std::string fault = frameFault(header, frame);
  if (!fault.empty()) return refuse(ServoKind::kServoTwist, fault);
  if (!v_R.allFinite() || !w_R.allFinite()) return notFinite(ServoKind::kServoTwist);
  ServoCommand command = commandOf(arm, ServoKind::kServoTwist);
  command.v_B = toArray(frame.X_BR.R * v_R);
  command.w_B = toArray(frame.X_BR.R * w_R);
  return {command, ""};
}

/** Axis times angle, 0 to 2 pi: of a rotation by more than pi, w is negative. */
Vector3 longTurn(const Quaternion& q) {
  const double sine = q.vec().norm();
  return sine > 0.0 ? Vector3(q.vec() / sine * (2.0 * std::atan2(sine, q.w()))) : Vector3(Vector3::Zero());
}

/** Limits of ServoJoints, then of the jaws, as control::ServoTarget has them. */
std::pair<double, double> limitsOf(const ArmGeometry& geometry, std::size_t joint) {
  if (joint == kServoJointCount) return {control::kMinOpening, control::kMaxOpening};
  if (joint + 1 == kServoJointCount) return {geometry.q_min[kGrasp1], geometry.q_max[kGrasp2]};
  return {geometry.q_min[joint], geometry.q_max[joint]};
}

/** Why positions of an arm and its jaws are beyond their limits; empty: they are not. */
std::string rangeFault(const ArmGeometry& geometry, const ServoCommand& joints, const ServoCommand& jaw) {
  for (std::size_t j = 0; j <= kServoJointCount; ++j) {
    const bool is_jaw = j == kServoJointCount;
    const double value = is_jaw ? jaw.jaw : joints.joints[j];
    const auto [low, high] = limitsOf(geometry, j);
    const double used = control::ontoLimit(value, low, high);
    if (used >= low && used <= high) continue;
    ServoRefused refused;
    refused.kind = joints.kind;
    refused.reason = ServoRefusal::kOutOfRange;
    refused.joint = static_cast<std::uint8_t>(j);
    refused.value = value;
    refused.limit = value < low ? low : high;
    return sentence(refused);
  }
  return "";
}

/** Of one number: the shoulder's, the others stay. */
CrtkAsked readRavensShoulder(Arm arm, ServoKind kind, double number) {
  if (!std::isfinite(number)) return notFinite(kind);
  ServoCommand command = commandOf(arm, kind);
  command.joints.front() = number;
  command.is_shoulder = 1;
  return {command, ""};
}

}  // namespace

CrtkAsked readState(Arm arm, const std::string& word) {
  const auto* const found = std::find(kStateCommandNames.begin(), kStateCommandNames.end(), word);
  if (found == kStateCommandNames.end())
    return refuse(ServoKind::kState, "\"" + word + "\" is unknown; known are " + listed(kStateCommandNames));
  ServoCommand command = commandOf(arm, ServoKind::kState);
  command.state = static_cast<StateCommand>(found - kStateCommandNames.begin());
  return {command, ""};
}

CrtkAsked readPlain(Arm arm, ServoKind kind) {
  return {commandOf(arm, kind), ""};
}

CrtkAsked readJoints(Arm arm, ServoKind kind, const sensor_msgs::JointState& message) {
  const std::string fault = jointsFault(kind, message, kServoJointNames);
  if (!fault.empty()) return refuse(kind, fault);
  ServoCommand command = commandOf(arm, kind);
  const std::vector<double>& numbers = numbersOf(kind, message);
  std::copy(numbers.begin(), numbers.end(), command.joints.begin());
  return {command, ""};
}

CrtkAsked readJaw(Arm arm, ServoKind kind, const sensor_msgs::JointState& message) {
  const std::string fault = jointsFault(kind, message, std::array<const char*, 1>{kJawName});
  if (!fault.empty()) return refuse(kind, fault);
  ServoCommand command = commandOf(arm, kind);
  command.jaw = numbersOf(kind, message)[0];
  return {command, ""};
}

CrtkAsked readPose(Arm arm, ServoKind kind, const CrtkFrame& frame, const geometry_msgs::PoseStamped& message) {
  return poseIn(arm, kind, frame, message.header, vectorOf(message.pose.position), message.pose.orientation);
}

CrtkAsked readTwist(Arm arm, const CrtkFrame& frame, const geometry_msgs::TwistStamped& message) {
  return twistIn(arm, frame, message.header, vectorOf(message.twist.linear), vectorOf(message.twist.angular));
}

CrtkAsked readWrench(Arm arm, const CrtkFrame& frame, WrenchFrame where, const geometry_msgs::WrenchStamped& message) {
  constexpr ServoKind kKind = ServoKind::kServoWrench;
  const std::string fault = frameFault(message.header, frame);
  if (!fault.empty()) return refuse(kKind, fault);
  const Vector3 force_R = vectorOf(message.wrench.force), torque_R = vectorOf(message.wrench.torque);
  if (!force_R.allFinite() || !torque_R.allFinite()) return notFinite(kKind);
  ServoCommand command = commandOf(arm, kKind);
  command.frame = where;
  const Matrix3 R_BR = where == WrenchFrame::kBody ? Matrix3::Identity() : frame.X_BR.R;
  const Vector3 force = R_BR * force_R;
  Vector3 torque = R_BR * torque_R;
  if (where == WrenchFrame::kOrigin) torque += frame.X_BR.p.cross(force);  // about the origin of B
  command.force = toArray(force);
  command.torque = toArray(torque);
  return {command, ""};
}

CrtkAsked readNumber(Arm arm, ServoKind kind, double number) {
  if (!std::isfinite(number)) return notFinite(kind);
  ServoCommand command = commandOf(arm, kind);
  command.number = number;
  return {command, ""};
}

CrtkAsked readTransform(Arm arm,
                        ServoKind kind,
                        const CrtkFrame& frame,
                        const geometry_msgs::TransformStamped& message) {
  const geometry_msgs::Transform& X = message.transform;
  return poseIn(arm, kind, frame, message.header, vectorOf(X.translation), X.rotation);
}

CrtkAsked readRavenJoints(const ArmGeometry& geometry,
                          Arm arm,
                          ServoKind kind,
                          const sensor_msgs::JointState& message) {
  const bool is_position = kind == ServoKind::kServoJoints;
  const std::vector<double>& numbers = numbersOf(kind, message);
  const std::size_t count = numbers.size();
  if (count == 1) return readRavensShoulder(arm, kind, numbers[0]);
  if (count < kJointCount || (count > kJointCount && is_position))
    return refuse(kind, std::to_string(count) + numbersName(kind) +
                            " where there are 7 joints: " + listed(kJointNames) + ", or 1, the shoulder");
  if (!areFinite(numbers)) return notFinite(kind);
  JointArray q{};
  std::copy_n(numbers.begin(), kJointCount, q.begin());
  ServoCommand joints = commandOf(arm, kind);
  joints.joints = control::servoJoints(q);
  if (kind == ServoKind::kServoRates) return {joints, ""};
  ServoCommand jaw = commandOf(arm, is_position ? ServoKind::kServoJaw : ServoKind::kServoJawBy);
  jaw.jaw = kinematics::jawOpening(q);
  if (!is_position && jaw.jaw == 0.0) return {joints, ""};
  const std::string fault = is_position ? rangeFault(geometry, joints, jaw) : "";
  if (!fault.empty()) return {std::nullopt, fault};
  return {joints, "", jaw};
}

CrtkAsked readRavenJaw(Arm arm, ServoKind kind, const sensor_msgs::JointState& message) {
  sensor_msgs::JointState unnamed = message;
  unnamed.name.clear();
  for (auto* const numbers : {&unnamed.position, &unnamed.effort})
    if (numbers->size() >= kJointCount) numbers->resize(1);
  return readJaw(arm, kind, unnamed);
}

CrtkAsked readTransformTwist(Arm arm, const CrtkFrame& frame, const geometry_msgs::TransformStamped& message) {
  const Turn turn = turnOf(message.transform.rotation);
  if (!turn.fault.empty()) return refuse(ServoKind::kServoTwist, turn.fault);
  return twistIn(arm, frame, message.header, vectorOf(message.transform.translation), longTurn(turn.q));
}

}  // namespace raven2_trainer::ros_bridge
