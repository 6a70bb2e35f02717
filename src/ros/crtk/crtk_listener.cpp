#include "ros/crtk/crtk_listener.h"

#include <ros/message_event.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Empty.h>
#include <std_msgs/Float64.h>

#include <memory>
#include <utility>

#include "raven2_trainer/net/clock.h"
#include "ros/crtk/crtk_messages.h"
#include "ros/node/registration.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::uint32_t kNewest = 1;    // [messages] servo commands take each other's place
constexpr std::uint32_t kEvery = 100;   // [messages] of those that add up, 0.1 s of the fastest client
constexpr std::uint32_t kOrdered = 10;  // [messages] moves and state commands
constexpr double kLeaving = 0.1;        // [s] between two looks whether the clients of a twist are still there

std::uint32_t queueOf(ServoKind kind) {
  switch (kind) {
    case ServoKind::kServoJointsBy:
    case ServoKind::kServoPoseBy:
    case ServoKind::kServoJawBy:
      return kEvery;
    case ServoKind::kServoJoints:
    case ServoKind::kServoPose:
    case ServoKind::kServoTwist:
    case ServoKind::kServoRates:
    case ServoKind::kServoForces:
    case ServoKind::kServoWrench:
    case ServoKind::kServoJawForce:
    case ServoKind::kServoJaw:
      return kNewest;
    default:
      return kOrdered;
  }
}

const char* topicOf(ServoKind kind) {
  return kServoKindNames[static_cast<std::size_t>(kind)];
}

/** @return what ends a command that goes on without another message; none for other commands. */
std::optional<ServoKind> endOf(ServoKind kind) {
  switch (kind) {
    case ServoKind::kServoTwist:
      return ServoKind::kEndTwist;
    case ServoKind::kServoRates:
      return ServoKind::kEndRates;
    case ServoKind::kServoForces:
    case ServoKind::kServoWrench:
    case ServoKind::kServoJawForce:
      return ServoKind::kEndForces;
    default:
      return std::nullopt;
  }
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
                           const CrtkConfig& config,
                           const ArmGeometry& geometry,
                           const Pose& X_WB,
                           bool may_command,
                           const std::optional<CrtkPublishers>& before,
                           CrtkInbox* inbox,
                           CrtkVoice* voice)
    : node_(node),
      arm_(arm),
      name_(at(config.names, arm)),
      jaw_name_(jawNamespace(config, arm)),
      is_raven_(config.dialect == CrtkDialect::kRaven),
      is_transform_(config.dialect == CrtkDialect::kTransform),
      geometry_(geometry),
      world_(worldFrame(X_WB)),
      base_(baseFrame(arm)),
      before_(before),
      inbox_(*inbox),
      voice_(*voice) {
  for (const ServoKind end : {ServoKind::kEndTwist, ServoKind::kEndRates, ServoKind::kEndForces})
    lasting_.try_emplace(
        end, [this](const std::string& topic) { return subscribers_[by_topic_.at(topic)].getNumPublishers(); },
        [this](const std::string& topic) { return publishersOf({subscribers_[by_topic_.at(topic)].getTopic()}); },
        twistTimeout(config));
  hearState(inArm("state_command"), may_command);
  if (is_raven_ && arm == Arm::kGold) hearState("state_command", may_command);  // of both arms, as there
  hearPlain(ServoKind::kHold);
  if (!may_command) return;
  hearMotion();
  config.dialect == CrtkDialect::kRaven ? hearRaven() : hearModern();
  hearForces();
  hearSettings();
  timer_ = node_.createWallTimer(ros::WallDuration(kLeaving), [this](const ros::WallTimerEvent&) { endLeft(); });
}

void CrtkListener::hearState(const std::string& topic, bool may_command) {
  hear<crtk::StringStamped>(topic, kOrdered, [this, may_command](const crtk::StringStamped& message) {
    CrtkAsked asked = readState(arm_, message.string);
    if (may_command || !asked.command || isSafer(*asked.command)) return asked;
    return CrtkAsked{std::nullopt, "state_command: a network may pause and disable, no more (enable_remote_control)"};
  });
}

void CrtkListener::hearMotion() {
  hearPlain(ServoKind::kFree);
  hearJoints(ServoKind::kMoveJoints);
  hearJoints(ServoKind::kMoveJointsBy);
  hearPose(ServoKind::kMovePose, world_);
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy, ServoKind::kMovePose})
    hearPose(kind, base_);
  hearTwist(base_);
  hearJaw(jaw_name_ + "/servo_jp", ServoKind::kServoJaw);
  hearJaw(jaw_name_ + "/servo_jr", ServoKind::kServoJawBy);
  hearJaw(jaw_name_ + "/move_jp", ServoKind::kMoveJaw);
  hearJaw(jaw_name_ + "/move_jr", ServoKind::kMoveJawBy);
  hearJaw(jaw_name_ + "/servo_jf", ServoKind::kServoJawForce);
  hear<sensor_msgs::JointState>(jaw_name_ + "/servo_jv", kNewest, [](const sensor_msgs::JointState&) {
    return CrtkAsked{std::nullopt, "jaw/servo_jv: the jaws have no rate of their own; servo_jp and move_jp open them"};
  });
}

/** Torques and forces, which the model alone can follow. */
void CrtkListener::hearForces() {
  hearJoints(ServoKind::kServoForces);
  hearWrench("", world_, WrenchFrame::kTip);
  hearWrench("local/", base_, WrenchFrame::kTip);
  hearWrench("spatial/", world_, WrenchFrame::kOrigin);
  hearWrench("body/", {"", {}, Pose{}}, WrenchFrame::kBody);
  hear<std_msgs::Bool>(inArm("body/set_cf_orientation_absolute"), kOrdered, [this](const std_msgs::Bool& message) {
    is_absolute_ = message.data != 0;
    return CrtkAsked{};
  });
  hear<std_msgs::Bool>(inArm("spatial/set_cf_orientation_absolute"), kOrdered,
                       [](const std_msgs::Bool&) { return CrtkAsked{}; });  // it is
}

void CrtkListener::hearWrench(const std::string& prefix, const CrtkFrame& frame, WrenchFrame where) {
  using geometry_msgs::WrenchStamped;
  hear<WrenchStamped>(
      inArm(prefix + topicOf(ServoKind::kServoWrench)), kNewest, [this, frame, where](const WrenchStamped& message) {
        const bool turns = where == WrenchFrame::kBody && is_absolute_;
        return turns ? readWrench(arm_, world_, WrenchFrame::kTip, message) : readWrench(arm_, frame, where, message);
      });
}

/** Settings of dVRK's clients. */
void CrtkListener::hearSettings() {
  hear<std_msgs::Float64>(inArm(topicOf(ServoKind::kRatio)), kOrdered, [this](const std_msgs::Float64& message) {
    return readNumber(arm_, ServoKind::kRatio, message.data);
  });
  for (const ServoKind kind : {ServoKind::kGravity, ServoKind::kTool})
    hear<std_msgs::Bool>(inArm(topicOf(kind)), kOrdered, [this, kind](const std_msgs::Bool& message) {
      return readNumber(arm_, kind, message.data != 0 ? 1.0 : 0.0);
    });
}

/** A client that is gone cannot stop its twist. roscpp does not say whose a message was, so each that goes ends it. A
 * force may have been refused by the loop: its client ends no twist. */
void CrtkListener::endLeft() {
  for (auto& [end, lasting] : lasting_)
    if (lasting.hasLost(net::monotonicNow())) take("left", readNumber(arm_, end, 0.0));
}

void CrtkListener::hearModern() {
  for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kServoJointsBy, ServoKind::kServoRates})
    hearJoints(kind);
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoPoseBy})
    hearPose(kind, world_);
  hearTwist(world_);
}

/** Topics in which the robot's own branch differs. */
void CrtkListener::hearRaven() {
  using geometry_msgs::TransformStamped;
  using sensor_msgs::JointState;
  const CrtkFrame frame = ravenFrame(arm_);
  for (const ServoKind kind : {ServoKind::kServoJoints, ServoKind::kServoJointsBy, ServoKind::kServoRates})
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
  auto* const read = is_raven_ ? &readRavenJaw : &readJaw;
  hear<sensor_msgs::JointState>(topic, queueOf(kind), [this, kind, read](const sensor_msgs::JointState& message) {
    return read(arm_, kind, message);
  });
}

void CrtkListener::hearPose(ServoKind kind, const CrtkFrame& frame) {
  using geometry_msgs::PoseStamped;
  using geometry_msgs::TransformStamped;
  const std::string topic = inArm((frame.name == base_.name ? "local/" : "") + std::string(topicOf(kind)));
  if (is_transform_) {
    hear<TransformStamped>(topic, queueOf(kind), [this, kind, frame](const TransformStamped& message) {
      return readTransform(arm_, kind, frame, message);
    });
  } else {
    hear<PoseStamped>(topic, queueOf(kind),
                      [this, kind, frame](const PoseStamped& message) { return readPose(arm_, kind, frame, message); });
  }
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
    const ros::Time stamp = stampOf(message);
    const CrtkOrigin origin{event.getPublisherName(), stored->storageOf(event.getConnectionHeaderPtr(), stamp), stamp,
                            ros::Time::now()};
    take(topic, unlessOld(read(message), origin));
  };
  const auto at_once = ros::TransportHints().tcpNoDelay();
  subscribers_.push_back(node_.subscribe<Message, const Event&>(topic, queue, callback, ros::VoidConstPtr(), at_once));
  by_topic_[topic] = subscribers_.size() - 1;
}

void CrtkListener::take(const std::string& topic, const CrtkAsked& asked) {
  if (asked.isNothing()) return;
  const std::string refusal = inbox_.take(asked);
  const auto end = asked.command ? endOf(asked.command->kind) : std::nullopt;
  if (end) lasting_.at(*end).take(topic, net::monotonicNow());
  if (!refusal.empty()) voice_.complain(CrtkLevel::kWarning, topic, refusal, net::monotonicNow());
}

}  // namespace raven2_trainer::ros_bridge
