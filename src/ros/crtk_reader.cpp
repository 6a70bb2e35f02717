#include "ros/crtk_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "ros/crtk_words.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** Of a quaternion's length from 1, as ITP's receivers allow (reliability.md 2.2). */
constexpr double kUnitTolerance = 0.02;

std::string kindName(ServoKind kind) {
  return kServoKindNames[static_cast<std::size_t>(kind)];
}

CrtkAsked refuse(ServoKind kind, const std::string& why) {
  return {std::nullopt, kindName(kind) + ": " + why};
}

CrtkAsked notFinite(ServoKind kind) {
  return refuse(kind, "a number that is not finite");
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

/** Why the joints of a message are not those that are wanted; empty: they are. */
template <typename Names>
std::string jointsFault(const sensor_msgs::JointState& message, const Names& wanted) {
  const std::string list = listed(wanted);
  if (message.position.size() != wanted.size())
    return std::to_string(message.position.size()) + " positions where there are " + std::to_string(wanted.size()) +
           " joints: " + list;
  const bool is_named = !message.name.empty();
  if (is_named && !std::equal(message.name.begin(), message.name.end(), wanted.begin(), wanted.end()))
    return "the joints are named " + listed(message.name) + "; it is " + list + ", in this order, or no names";
  return areFinite(message.position) ? "" : "a number that is not finite";
}

/** Why nothing can be said in a message's frame; empty: it can. */
std::string frameFault(const std_msgs::Header& header, const CrtkFrame& frame) {
  const std::string& name = header.frame_id;
  const auto& allowed = frame.allowed;
  if (name.empty() || std::find(allowed.begin(), allowed.end(), name) != allowed.end()) return "";
  const std::string known = allowed.empty() ? "no frame_id" : listed(allowed) + " or no frame_id";
  return "in frame \"" + name + "\"; it is " + known;
}

/** A turn of the client's. */
struct Turn {
  Quaternion q{Quaternion::Identity()};
  std::string fault;
};

Turn turnOf(const geometry_msgs::Quaternion& r) {
  const Quaternion q(r.w, r.x, r.y, r.z);
  const double length = q.norm();
  if (!std::isfinite(length)) return {Quaternion::Identity(), "a number that is not finite"};
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

/** Axis times angle, 0 to 2 pi: of a turn by more than a half, w is negative. */
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
    if (value >= low && value <= high) continue;
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

}  // namespace

CrtkAsked readState(Arm arm, const std::string& word) {
  const auto* const found = std::find(kStateCommandNames.begin(), kStateCommandNames.end(), word);
  if (found == kStateCommandNames.end())
    return refuse(ServoKind::kState, "\"" + word + "\" is none; there are " + listed(kStateCommandNames));
  ServoCommand command = commandOf(arm, ServoKind::kState);
  command.state = static_cast<StateCommand>(found - kStateCommandNames.begin());
  return {command, ""};
}

CrtkAsked readPlain(Arm arm, ServoKind kind) {
  return {commandOf(arm, kind), ""};
}

CrtkAsked readJoints(Arm arm, ServoKind kind, const sensor_msgs::JointState& message) {
  const std::string fault = jointsFault(message, kServoJointNames);
  if (!fault.empty()) return refuse(kind, fault);
  ServoCommand command = commandOf(arm, kind);
  std::copy(message.position.begin(), message.position.end(), command.joints.begin());
  return {command, ""};
}

CrtkAsked readJaw(Arm arm, ServoKind kind, const sensor_msgs::JointState& message) {
  const std::string fault = jointsFault(message, std::array<const char*, 1>{kJawName});
  if (!fault.empty()) return refuse(kind, fault);
  ServoCommand command = commandOf(arm, kind);
  command.jaw = message.position[0];
  return {command, ""};
}

CrtkAsked readPose(Arm arm, ServoKind kind, const CrtkFrame& frame, const geometry_msgs::PoseStamped& message) {
  return poseIn(arm, kind, frame, message.header, vectorOf(message.pose.position), message.pose.orientation);
}

CrtkAsked readTwist(Arm arm, const CrtkFrame& frame, const geometry_msgs::TwistStamped& message) {
  return twistIn(arm, frame, message.header, vectorOf(message.twist.linear), vectorOf(message.twist.angular));
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
  const bool is_by = kind == ServoKind::kServoJointsBy;
  const std::size_t count = message.position.size();
  if (count < kJointCount || (count > kJointCount && !is_by))
    return refuse(kind, std::to_string(count) + " positions where there are 7 joints: " + listed(kJointNames));
  if (!areFinite(message.position)) return notFinite(kind);
  JointArray q{};
  std::copy_n(message.position.begin(), kJointCount, q.begin());
  ServoCommand joints = commandOf(arm, kind);
  ServoCommand jaw = commandOf(arm, is_by ? ServoKind::kServoJawBy : ServoKind::kServoJaw);
  joints.joints = control::servoJoints(q);
  jaw.jaw = kinematics::jawOpening(q);
  if (is_by && jaw.jaw == 0.0) return {joints, ""};
  const std::string fault = is_by ? "" : rangeFault(geometry, joints, jaw);
  if (!fault.empty()) return {std::nullopt, fault};
  return {joints, "", jaw};
}

CrtkAsked readTransformTwist(Arm arm, const CrtkFrame& frame, const geometry_msgs::TransformStamped& message) {
  const Turn turn = turnOf(message.transform.rotation);
  if (!turn.fault.empty()) return refuse(ServoKind::kServoTwist, turn.fault);
  return twistIn(arm, frame, message.header, vectorOf(message.transform.translation), longTurn(turn.q));
}

}  // namespace raven2_trainer::ros_bridge
