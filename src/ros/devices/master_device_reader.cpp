#include "ros/devices/master_device_reader.h"

#include <geometry_msgs/PoseStamped.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Joy.h>

#include <algorithm>
#include <vector>

#include "ros/crtk/crtk_messages.h"
#include "ros/devices/master_device_messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int32_t kPressed = 1;  ///< cisst's drivers send 2 after a quick click, when it is up again

template <typename Message>
const char* md5Of() {
  return ros::message_traits::MD5Sum<Message>::value();
}

/** By the check sum alone: the same message goes by several packages' names. */
template <typename Message>
bool decode(const topic_tools::ShapeShifter& message, Message* out) {
  std::vector<std::uint8_t> bytes(message.size());
  ros::serialization::OStream copy(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  message.write(copy);
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  try {
    ros::serialization::deserialize(stream, *out);
  } catch (const ros::Exception&) {  // shorter than its check sum promises
    return false;
  }
  return true;
}

void take(const geometry_msgs::Pose& pose, DeviceSample* sample) {
  sample->position = {pose.position.x, pose.position.y, pose.position.z};
  sample->orientation = {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w};
  ++sample->poses;
}

void take(const sensor_msgs::Joy& joy, DeviceSample* sample) {
  sample->axis_count = static_cast<std::uint32_t>(std::min(joy.axes.size(), sample->axes.size()));
  std::copy_n(joy.axes.begin(), sample->axis_count, sample->axes.begin());
  ++sample->poses;
}

}  // namespace

MasterDeviceReader::MasterDeviceReader(const MasterConfig& config, const DeviceTopics& topics)
    : config_(config), topics_(topics) {
  sample_.is_stateless = topics.operating_state.empty() ? 0 : 1;
  sample_.is_ready = topics.operating_state.empty() ? 1 : 0;
}

bool MasterDeviceReader::pose(const topic_tools::ShapeShifter& message) {
  const std::string& md5 = message.getMD5Sum();
  if (traitsOf(config_.family).has_axes) {
    sensor_msgs::Joy joy;
    if (md5 != md5Of<sensor_msgs::Joy>()) return refuse(message, topics_.pose, "sensor_msgs/Joy");
    if (!decode(message, &joy)) return false;
    for (std::size_t i = 0; i < 32; ++i)
      setButton(i, i < joy.buttons.size() && joy.buttons[i] == kPressed);
    take(joy, &sample_);
    return true;
  }
  if (md5 == devices::OmniState::md5()) {
    devices::OmniState state;
    if (!decode(message, &state)) return false;
    sample_.is_locked = state.locked;
    frame_ = state.header.frame_id;
    take(state.pose, &sample_);
    return true;
  }
  geometry_msgs::PoseStamped stamped;
  if (md5 != md5Of<geometry_msgs::PoseStamped>())
    return refuse(message, topics_.pose, "geometry_msgs/PoseStamped, omni_msgs/OmniState");
  if (!decode(message, &stamped)) return false;
  // CRTK: a sample without a time is not valid
  if (traitsOf(config_.family).stamps_samples && stamped.header.stamp.isZero()) return true;
  frame_ = stamped.header.frame_id;
  take(stamped.pose, &sample_);
  return true;
}

bool MasterDeviceReader::buttons(const topic_tools::ShapeShifter& message, std::size_t topic) {
  const std::string& md5 = message.getMD5Sum();
  const bool is_alone = topics_.buttons.size() == 1;
  if (md5 == devices::ButtonEvent::md5()) {
    devices::ButtonEvent event;
    if (!decode(message, &event)) return false;
    setButton(is_alone ? 0 : topic, event.grey_button == kPressed);
    if (is_alone) setButton(1, event.white_button == kPressed);
    return true;
  }
  sensor_msgs::Joy joy;
  if (md5 != md5Of<sensor_msgs::Joy>())
    return refuse(message, topics_.buttons[topic], "sensor_msgs/Joy, OmniButtonEvent, DeviceButtonEvent");
  if (!decode(message, &joy)) return false;
  if (!is_alone) {
    setButton(topic, !joy.buttons.empty() && joy.buttons[0] == kPressed);
    return true;
  }
  for (std::size_t i = 0; i < 32; ++i)
    setButton(i, i < joy.buttons.size() && joy.buttons[i] == kPressed);
  return true;
}

bool MasterDeviceReader::gripper(const topic_tools::ShapeShifter& message) {
  sensor_msgs::JointState joints;
  if (message.getMD5Sum() != md5Of<sensor_msgs::JointState>())
    return refuse(message, topics_.gripper, "sensor_msgs/JointState");
  if (!decode(message, &joints)) return false;
  if (joints.position.empty()) return true;
  sample_.gripper = joints.position[0];
  sample_.has_gripper = 1;
  return true;
}

bool MasterDeviceReader::operatingState(const topic_tools::ShapeShifter& message) {
  crtk::OperatingState state;
  if (message.getMD5Sum() != crtk::OperatingState::md5())
    return refuse(message, topics_.operating_state, "crtk_msgs/OperatingState");
  if (!decode(message, &state)) return false;
  sample_.is_stateless = 0;
  sample_.is_ready = state.state == "ENABLED" && state.is_homed != 0 ? 1 : 0;
  return true;
}

bool MasterDeviceReader::refuse(const topic_tools::ShapeShifter& message, const std::string& topic, const char* known) {
  const std::string type = topic + " " + message.getDataType() + " " + message.getMD5Sum();
  if (type != refused_) {
    refusal_ = "refused: " + topic + " is of type " + message.getDataType() + " (check sum " + message.getMD5Sum() +
               "); known there: " + known;
  }
  refused_ = type;
  return false;
}

std::string MasterDeviceReader::refusal() {
  std::string line;
  line.swap(refusal_);
  return line;
}

void MasterDeviceReader::setButton(std::size_t number, bool held) noexcept {
  if (number >= 32) return;
  const std::uint32_t bit = 1U << number;
  sample_.buttons = held ? sample_.buttons | bit : sample_.buttons & ~bit;
}

bool readJoyButton(const topic_tools::ShapeShifter& message, int button, bool* held) {
  sensor_msgs::Joy joy;
  if (message.getMD5Sum() != md5Of<sensor_msgs::Joy>() || !decode(message, &joy)) return false;
  if (static_cast<std::size_t>(button) >= joy.buttons.size()) return false;
  *held = joy.buttons[static_cast<std::size_t>(button)] == kPressed;
  return true;
}

}  // namespace raven2_trainer::ros_bridge
