#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Vector3.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <string>
#include <vector>

// Messages of haptic devices' drivers, whose packages are not in Debian: fields, order and check sums as there.
//   omni_msgs         OmniState, OmniButtonEvent, OmniFeedback: github.com/bharatm11/Geomagic_Touch_ROS_Drivers,
//                     omni_msgs/msg (of fsuarez6/phantom_omni)
//   geomagic_control  DeviceButtonEvent, DeviceFeedback: github.com/WPI-AIM/ros_geomagic, geomagic_control/msg; the
//                     former has the fields of OmniButtonEvent, and so its check sum
//   crtk_msgs         OperatingState: github.com/collaborative-robotics/crtk_msgs, msg
// The check sums are genmsg's of those texts.

namespace raven2_trainer::ros_bridge::devices {

/** omni_msgs/OmniState. */
struct OmniState {
  std_msgs::Header header;
  std::uint8_t locked{}, close_gripper{};  // bool
  geometry_msgs::Pose pose;                // position in the driver's ~units
  geometry_msgs::Vector3 current;          // [A]
  geometry_msgs::Vector3 velocity;         // ~units a second

  static const char* md5() { return "89c2a741de66e9e904f59a02b171dd6e"; }
};

/** omni_msgs/OmniButtonEvent and geomagic_control/DeviceButtonEvent. */
struct ButtonEvent {
  std::int32_t grey_button{}, white_button{};

  static const char* md5() { return "fb77877e6b639935c3360838062f05f0"; }
};

/** omni_msgs/OmniFeedback. */
struct OmniFeedback {
  geometry_msgs::Vector3 force;     // [N]
  geometry_msgs::Vector3 position;  // where a locked device is held, in ~units

  static const char* md5() { return "e9083ac4fd95494e94fbb0c0f90b6c00"; }
  static const char* name() { return "omni_msgs/OmniFeedback"; }
  static const char* text() { return "geometry_msgs/Vector3  force\ngeometry_msgs/Vector3  position\n"; }
};

/** geomagic_control/DeviceFeedback. */
struct DeviceFeedback {
  geometry_msgs::Vector3 force;     // [N]
  geometry_msgs::Vector3 position;  // [mm] where a locked axis is held
  std::vector<std::uint8_t> lock;   // bool, x, y, z: the driver reads three, whatever came

  static const char* md5() { return "94755b031db27fe99c2c235c0da9b072"; }
  static const char* name() { return "geomagic_control/DeviceFeedback"; }
  static const char* text() { return "geometry_msgs/Vector3  force\ngeometry_msgs/Vector3  position\nbool[] lock\n"; }
};

/** crtk_msgs/OperatingState. */
struct OperatingState {
  std_msgs::Header header;
  std::string state;  // DISABLED, ENABLED, PAUSED, FAULT
  std::uint8_t is_homed{}, is_busy{};

  static const char* md5() { return "b1bd4021639d9d9c5fbfff78d6ff3158"; }
};

/** A message's text with that of geometry_msgs/Vector3, as a topic's connection header carries it. */
std::string withVector3(const char* text);

}  // namespace raven2_trainer::ros_bridge::devices

namespace ros {
namespace message_traits {

namespace devices = raven2_trainer::ros_bridge::devices;

/** Of those that are published: a check sum, a name and a text. */
template <typename Feedback>
struct FeedbackMd5 {
  static const char* value() { return Feedback::md5(); }
  static const char* value(const Feedback&) { return value(); }
};
template <typename Feedback>
struct FeedbackName {
  static const char* value() { return Feedback::name(); }
  static const char* value(const Feedback&) { return value(); }
};
template <typename Feedback>
struct FeedbackText {
  static const char* value() {
    static const std::string text = devices::withVector3(Feedback::text());
    return text.c_str();
  }
  static const char* value(const Feedback&) { return value(); }
};

template <>
struct MD5Sum<devices::OmniFeedback> : FeedbackMd5<devices::OmniFeedback> {};
template <>
struct DataType<devices::OmniFeedback> : FeedbackName<devices::OmniFeedback> {};
template <>
struct Definition<devices::OmniFeedback> : FeedbackText<devices::OmniFeedback> {};
template <>
struct MD5Sum<devices::DeviceFeedback> : FeedbackMd5<devices::DeviceFeedback> {};
template <>
struct DataType<devices::DeviceFeedback> : FeedbackName<devices::DeviceFeedback> {};
template <>
struct Definition<devices::DeviceFeedback> : FeedbackText<devices::DeviceFeedback> {};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<message_traits::devices::OmniState> {
  template <typename Stream, typename State>
  static void allInOne(Stream& stream, State m) {
    stream.next(m.header);
    stream.next(m.locked);
    stream.next(m.close_gripper);
    stream.next(m.pose);
    stream.next(m.current);
    stream.next(m.velocity);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::devices::ButtonEvent> {
  template <typename Stream, typename Event>
  static void allInOne(Stream& stream, Event m) {
    stream.next(m.grey_button);
    stream.next(m.white_button);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::devices::OmniFeedback> {
  template <typename Stream, typename Feedback>
  static void allInOne(Stream& stream, Feedback m) {
    stream.next(m.force);
    stream.next(m.position);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::devices::DeviceFeedback> {
  template <typename Stream, typename Feedback>
  static void allInOne(Stream& stream, Feedback m) {
    stream.next(m.force);
    stream.next(m.position);
    stream.next(m.lock);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::devices::OperatingState> {
  template <typename Stream, typename State>
  static void allInOne(Stream& stream, State m) {
    stream.next(m.header);
    stream.next(m.state);
    stream.next(m.is_homed);
    stream.next(m.is_busy);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
