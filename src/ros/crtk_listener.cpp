#include "ros/crtk_listener.h"

#include <std_msgs/Empty.h>

#include "raven2_trainer/net/clock.h"
#include "ros/crtk_messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::uint32_t kNewest = 1;    // [messages] servo commands take each other's place
constexpr std::uint32_t kEvery = 100;   // [messages] of those that add up, 0.1 s of the fastest client
constexpr std::uint32_t kOrdered = 10;  // [messages] moves and state commands

std::uint32_t queueOf(ServoKind kind) {
  switch (kind) {
    case ServoKind::kServoJointsBy:
    case ServoKind::kServoPoseBy:
    case ServoKind::kServoJawBy:
      return kEvery;
    case ServoKind::kServoJoints:
    case ServoKind::kServoPose:
    case ServoKind::kServoTwist:
    case ServoKind::kServoJaw:
      return kNewest;
    default:
      return kOrdered;
  }
}

const char* topicOf(ServoKind kind) {
  return kServoKindNames[static_cast<std::size_t>(kind)];
}

/** What makes an arm safer, and who asks for it need not be trusted. */
bool isSafer(const std::string& word) {
  return word == "pause" || word == "disable";
}

}  // namespace

CrtkListener::CrtkListener(const ros::NodeHandle& node,
                           Arm arm,
                           const CrtkConfig& config,
                           const Pose& X_WB,
                           bool may_command,
                           CrtkInbox* inbox,
                           CrtkVoice* voice)
    : node_(node),
      arm_(arm),
      name_(at(config.names, arm)),
      world_(worldFrame(X_WB)),
      base_(baseFrame(arm)),
      inbox_(*inbox),
      voice_(*voice) {
  hearState(may_command);
  hearPlain(ServoKind::kHold);
  if (!may_command) return;
  hearMotion();
  hearDialect(config.dialect);
}

void CrtkListener::hearState(bool may_command) {
  hear<crtk::StringStamped>("state_command", kOrdered, [this, may_command](const crtk::StringStamped& message) {
    if (may_command || isSafer(message.string)) return readState(arm_, message.string);
    return CrtkAsked{std::nullopt, "state_command: a network may pause and disable, no more (enable_remote_control)"};
  });
}

void CrtkListener::hearMotion() {
  hearPlain(ServoKind::kFree);
  for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kServoJointsBy, ServoKind::kMoveJoints})
    hearJoints(kind);
  for (const ServoKind kind : {ServoKind::kServoJaw, ServoKind::kServoJawBy, ServoKind::kMoveJaw})
    hearJaw(kind);
  hearPose(ServoKind::kMovePose, world_);
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy, ServoKind::kMovePose})
    hearPose(kind, base_);
  hearTwist(base_);
}

/** The three that the robot's own branch has otherwise. */
void CrtkListener::hearDialect(CrtkDialect dialect) {
  if (dialect == CrtkDialect::kModern) {
    for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy})
      hearPose(kind, world_);
    hearTwist(world_);
    return;
  }
  using geometry_msgs::TransformStamped;
  const CrtkFrame frame = ravenFrame(arm_);
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy})
    hear<TransformStamped>(topicOf(kind), queueOf(kind), [this, kind, frame](const TransformStamped& message) {
      return readTransform(arm_, kind, frame, message);
    });
  hear<TransformStamped>(topicOf(ServoKind::kServoTwist), kNewest, [this, frame](const TransformStamped& message) {
    return readTransformTwist(arm_, frame, message);
  });
}

void CrtkListener::hearPlain(ServoKind kind) {
  hear<std_msgs::Empty>(topicOf(kind), kOrdered,
                        [this, kind](const std_msgs::Empty&) { return readPlain(arm_, kind); });
}

void CrtkListener::hearJoints(ServoKind kind) {
  hear<sensor_msgs::JointState>(topicOf(kind), queueOf(kind), [this, kind](const sensor_msgs::JointState& message) {
    return readJoints(arm_, kind, message);
  });
}

void CrtkListener::hearJaw(ServoKind kind) {
  hear<sensor_msgs::JointState>(topicOf(kind), queueOf(kind), [this, kind](const sensor_msgs::JointState& message) {
    return readJaw(arm_, kind, message);
  });
}

void CrtkListener::hearPose(ServoKind kind, const CrtkFrame& frame) {
  const std::string prefix = frame.name == base_.name ? "local/" : "";
  using geometry_msgs::PoseStamped;
  hear<PoseStamped>(prefix + topicOf(kind), queueOf(kind),
                    [this, kind, frame](const PoseStamped& message) { return readPose(arm_, kind, frame, message); });
}

void CrtkListener::hearTwist(const CrtkFrame& frame) {
  const std::string prefix = frame.name == base_.name ? "local/" : "";
  using geometry_msgs::TwistStamped;
  hear<TwistStamped>(prefix + topicOf(ServoKind::kServoTwist), kNewest,
                     [this, frame](const TwistStamped& message) { return readTwist(arm_, frame, message); });
}

template <typename Message>
void CrtkListener::hear(const std::string& topic, std::uint32_t queue, std::function<CrtkAsked(const Message&)> read) {
  const auto callback = [this, topic, read = std::move(read)](const boost::shared_ptr<const Message>& message) {
    take(topic, read(*message));
  };
  const auto at_once = ros::TransportHints().tcpNoDelay();
  subscribers_.push_back(node_.subscribe<Message>(name_ + "/" + topic, queue, callback, ros::VoidConstPtr(), at_once));
}

void CrtkListener::take(const std::string& topic, const CrtkAsked& asked) {
  const std::string refusal = inbox_.take(asked);
  if (!refusal.empty()) voice_.complain(CrtkLevel::kWarning, topic, refusal, net::monotonicNow());
}

}  // namespace raven2_trainer::ros_bridge
