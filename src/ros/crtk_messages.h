#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>

// Messages of the Collaborative Robotics Toolkit's package `crtk_msgs`, 1.3.0, which need not be installed: fields,
// order and check sums as there.

namespace raven2_trainer::ros_bridge::crtk {

/** crtk_msgs/OperatingState. The retired crtk_msgs/operating_state has the same fields, and so the same check sum. */
struct OperatingState {
  std_msgs::Header header;
  std::string state;  ///< DISABLED, ENABLED, PAUSED, FAULT
  std::uint8_t is_homed{}, is_busy{};
};

/** crtk_msgs/StringStamped. */
struct StringStamped {
  std_msgs::Header header;
  std::string string;
};

/** The text of each with that of std_msgs/Header, as a topic's connection header carries it. */
const char* operatingStateDefinition();
const char* stringStampedDefinition();

constexpr const char* kOperatingStateType = "crtk_msgs/OperatingState";
/** What the robot's own branch `crtk` calls it. */
constexpr const char* kRetiredOperatingStateType = "crtk_msgs/operating_state";

}  // namespace raven2_trainer::ros_bridge::crtk

namespace ros {
namespace message_traits {

namespace crtk = raven2_trainer::ros_bridge::crtk;

template <>
struct MD5Sum<crtk::OperatingState> {
  static const char* value() { return "b1bd4021639d9d9c5fbfff78d6ff3158"; }
  static const char* value(const crtk::OperatingState&) { return value(); }
};
template <>
struct DataType<crtk::OperatingState> {
  static const char* value() { return crtk::kOperatingStateType; }
  static const char* value(const crtk::OperatingState&) { return value(); }
};
template <>
struct Definition<crtk::OperatingState> {
  static const char* value() { return crtk::operatingStateDefinition(); }
  static const char* value(const crtk::OperatingState&) { return value(); }
};
template <>
struct HasHeader<crtk::OperatingState> : TrueType {};

template <>
struct MD5Sum<crtk::StringStamped> {
  static const char* value() { return "5e3e46086181199270f1ac3a28a5977f"; }
  static const char* value(const crtk::StringStamped&) { return value(); }
};
template <>
struct DataType<crtk::StringStamped> {
  static const char* value() { return "crtk_msgs/StringStamped"; }
  static const char* value(const crtk::StringStamped&) { return value(); }
};
template <>
struct Definition<crtk::StringStamped> {
  static const char* value() { return crtk::stringStampedDefinition(); }
  static const char* value(const crtk::StringStamped&) { return value(); }
};
template <>
struct HasHeader<crtk::StringStamped> : TrueType {};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<message_traits::crtk::OperatingState> {
  template <typename Stream, typename State>
  static void allInOne(Stream& stream, State m) {
    stream.next(m.header);
    stream.next(m.state);
    stream.next(m.is_homed);
    stream.next(m.is_busy);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::crtk::StringStamped> {
  template <typename Stream, typename Text>
  static void allInOne(Stream& stream, Text m) {
    stream.next(m.header);
    stream.next(m.string);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
