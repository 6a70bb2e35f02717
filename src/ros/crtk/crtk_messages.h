#pragma once

#include <std_msgs/Header.h>

#include <cstdint>
#include <string>

#include "ros/node/foreign_message.h"

// Messages of the Collaborative Robotics Toolkit's package `crtk_msgs`, 1.3.0.

namespace raven2_trainer::ros_bridge::crtk {

/** crtk_msgs/OperatingState. The retired crtk_msgs/operating_state has the same fields, and so the same check sum. */
struct OperatingState {
  std_msgs::Header header;
  std::string state;  ///< DISABLED, ENABLED, PAUSED, FAULT
  std::uint8_t is_homed{}, is_busy{};

  static const char* md5() { return "b1bd4021639d9d9c5fbfff78d6ff3158"; }
  static const char* name() { return "crtk_msgs/OperatingState"; }
  static std::string text() {
    return withPart<std_msgs::Header>("std_msgs/Header header\nstring state\nbool is_homed\nbool is_busy\n");
  }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.header, m.state, m.is_homed, m.is_busy);
  }
};

/** crtk_msgs/StringStamped. */
struct StringStamped {
  std_msgs::Header header;
  std::string string;

  static const char* md5() { return "5e3e46086181199270f1ac3a28a5977f"; }
  static const char* name() { return "crtk_msgs/StringStamped"; }
  static std::string text() { return withPart<std_msgs::Header>("std_msgs/Header header\nstring string\n"); }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.header, m.string);
  }
};

/** Name of OperatingState in the robot's own branch `crtk`. */
constexpr const char* kRetiredOperatingStateType = "crtk_msgs/operating_state";

}  // namespace raven2_trainer::ros_bridge::crtk

RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::crtk::OperatingState)
RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::crtk::StringStamped)

template <>
struct ros::message_traits::HasHeader<raven2_trainer::ros_bridge::crtk::OperatingState> : TrueType {};
template <>
struct ros::message_traits::HasHeader<raven2_trainer::ros_bridge::crtk::StringStamped> : TrueType {};
