#include "ros/crtk_listener.h"

#include <ros/message_event.h>
#include <std_msgs/Empty.h>

#include <memory>
#include <utility>

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

/** Zero: none. */
template <typename Message>
ros::Time stampOf(const Message& message) {
  const ros::Time* const stamp = ros::message_traits::timeStamp(message);
  return stamp == nullptr ? ros::Time() : *stamp;
}

}  // namespace

CrtkListener::CrtkListener(const ros::NodeHandle& node,
                           Arm arm,
                           const TrainerConfig& config,
                           const Pose& X_WB,
                           bool may_command,
                           const std::optional<CrtkPublishers>& before,
                           CrtkInbox* inbox,
                           CrtkVoice* voice)
    : node_(node),
      arm_(arm),
      name_(at(config.crtk.names, arm)),
      jaw_name_(jawNamespace(config.crtk, arm)),
      geometry_(config.arms.geometry),
      world_(worldFrame(X_WB)),
      base_(baseFrame(arm)),
      before_(before),
      inbox_(*inbox),
      voice_(*voice) {
  hearState(may_command);
  hearPlain(ServoKind::kHold);
  if (!may_command) return;
  hearMotion();
  config.crtk.dialect == CrtkDialect::kRaven ? hearRaven() : hearModern();
}

void CrtkListener::hearState(bool may_command) {
  hear<crtk::StringStamped>(inArm("state_command"), kOrdered, [this, may_command](const crtk::StringStamped& message) {
    CrtkAsked asked = readState(arm_, message.string);
    if (may_command || !asked.command || isSafer(*asked.command)) return asked;
    return CrtkAsked{std::nullopt, "state_command: a network may pause and disable, no more (enable_remote_control)"};
  });
}

void CrtkListener::hearMotion() {
  hearPlain(ServoKind::kFree);
  hearJoints(ServoKind::kMoveJoints);
  hearPose(ServoKind::kMovePose, world_);
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy, ServoKind::kMovePose})
    hearPose(kind, base_);
  hearTwist(base_);
  hearJaw(jaw_name_ + "/servo_jp", ServoKind::kServoJaw);
  hearJaw(jaw_name_ + "/servo_jr", ServoKind::kServoJawBy);
  hearJaw(jaw_name_ + "/move_jp", ServoKind::kMoveJaw);
}

void CrtkListener::hearModern() {
  for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kServoJointsBy})
    hearJoints(kind);
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy})
    hearPose(kind, world_);
  hearTwist(world_);
}

/** The five that the robot's own branch has otherwise. */
void CrtkListener::hearRaven() {
  using geometry_msgs::TransformStamped;
  using sensor_msgs::JointState;
  const CrtkFrame frame = ravenFrame(arm_);
  for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kServoJointsBy})
    hear<JointState>(inArm(topicOf(kind)), queueOf(kind), [this, kind](const JointState& message) {
      return readRavenJoints(geometry_, arm_, kind, message);
    });
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy})
    hear<TransformStamped>(inArm(topicOf(kind)), queueOf(kind), [this, kind, frame](const TransformStamped& message) {
      return readTransform(arm_, kind, frame, message);
    });
  hear<TransformStamped>(
      inArm(topicOf(ServoKind::kServoTwist)), kNewest,
      [this, frame](const TransformStamped& message) { return readTransformTwist(arm_, frame, message); });
}

void CrtkListener::hearPlain(ServoKind kind) {
  hear<std_msgs::Empty>(inArm(topicOf(kind)), kOrdered,
                        [this, kind](const std_msgs::Empty&) { return readPlain(arm_, kind); });
}

void CrtkListener::hearJoints(ServoKind kind) {
  hear<sensor_msgs::JointState>(
      inArm(topicOf(kind)), queueOf(kind),
      [this, kind](const sensor_msgs::JointState& message) { return readJoints(arm_, kind, message); });
}

void CrtkListener::hearJaw(const std::string& topic, ServoKind kind) {
  hear<sensor_msgs::JointState>(topic, queueOf(kind), [this, kind](const sensor_msgs::JointState& message) {
    return readJaw(arm_, kind, message);
  });
}

void CrtkListener::hearPose(ServoKind kind, const CrtkFrame& frame) {
  const std::string prefix = frame.name == base_.name ? "local/" : "";
  using geometry_msgs::PoseStamped;
  hear<PoseStamped>(inArm(prefix + topicOf(kind)), queueOf(kind),
                    [this, kind, frame](const PoseStamped& message) { return readPose(arm_, kind, frame, message); });
}

void CrtkListener::hearTwist(const CrtkFrame& frame) {
  const std::string prefix = frame.name == base_.name ? "local/" : "";
  using geometry_msgs::TwistStamped;
  hear<TwistStamped>(inArm(prefix + topicOf(ServoKind::kServoTwist)), kNewest,
                     [this, frame](const TwistStamped& message) { return readTwist(arm_, frame, message); });
}

CrtkStored CrtkListener::storedOf(const std::string& topic) const {
  if (!before_) return CrtkStored(std::nullopt);
  const auto found = before_->find(node_.resolveName(topic));
  return CrtkStored(found == before_->end() ? std::set<std::string>() : found->second);
}

template <typename Message>
void CrtkListener::hear(const std::string& topic, std::uint32_t queue, std::function<CrtkAsked(const Message&)> read) {
  using Event = ros::MessageEvent<const Message>;
  const auto stored = std::make_shared<CrtkStored>(storedOf(topic));
  const boost::function<void(const Event&)> callback = [this, topic, stored,
                                                        read = std::move(read)](const Event& event) {
    const Message& message = *event.getConstMessage();
    const bool may_be_stored = stored->mayBe(event.getConnectionHeaderPtr());
    const CrtkOrigin origin{event.getPublisherName(), may_be_stored, stampOf(message), ros::Time::now()};
    take(topic, unlessOld(read(message), origin));
  };
  const auto at_once = ros::TransportHints().tcpNoDelay();
  subscribers_.push_back(node_.subscribe<Message, const Event&>(topic, queue, callback, ros::VoidConstPtr(), at_once));
}

void CrtkListener::take(const std::string& topic, const CrtkAsked& asked) {
  const std::string refusal = inbox_.take(asked);
  if (!refusal.empty()) voice_.complain(CrtkLevel::kWarning, topic, refusal, net::monotonicNow());
}

}  // namespace raven2_trainer::ros_bridge
