#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Vector3.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <vector>

#include "ros/node/foreign_message.h"

// Messages of haptic devices' drivers, whose packages are not in Debian.
//   omni_msgs         OmniState, OmniButtonEvent, OmniFeedback: github.com/bharatm11/Geomagic_Touch_ROS_Drivers,
//                     omni_msgs/msg (of fsuarez6/phantom_omni)
//   geomagic_control  DeviceButtonEvent, DeviceFeedback: github.com/WPI-AIM/ros_geomagic, geomagic_control/msg; the
//                     former has the fields of OmniButtonEvent, and so its check sum
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
  static const char* name() { return "omni_msgs/OmniState"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.header, m.locked, m.close_gripper, m.pose, m.current, m.velocity);
  }
};

/** omni_msgs/OmniButtonEvent and geomagic_control/DeviceButtonEvent. */
struct ButtonEvent {
  std::int32_t grey_button{}, white_button{};

  static const char* md5() { return "fb77877e6b639935c3360838062f05f0"; }
  static const char* name() { return "omni_msgs/OmniButtonEvent"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.grey_button, m.white_button);
  }
};

/** omni_msgs/OmniFeedback. */
struct OmniFeedback {
  geometry_msgs::Vector3 force;     // [N]
  geometry_msgs::Vector3 position;  // where a locked device is held, in ~units

  static const char* md5() { return "e9083ac4fd95494e94fbb0c0f90b6c00"; }
  static const char* name() { return "omni_msgs/OmniFeedback"; }
  static std::string text() {
    return withPart<geometry_msgs::Vector3>("geometry_msgs/Vector3  force\ngeometry_msgs/Vector3  position\n");
  }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.force, m.position);
  }
};

/** geomagic_control/DeviceFeedback. */
struct DeviceFeedback {
  geometry_msgs::Vector3 force;     // [N]
  geometry_msgs::Vector3 position;  // [mm] where a locked axis is held
  std::vector<std::uint8_t> lock;   // bool, x, y, z: the driver reads three, whatever came

  static const char* md5() { return "94755b031db27fe99c2c235c0da9b072"; }
  static const char* name() { return "geomagic_control/DeviceFeedback"; }
  static std::string text() {
    return withPart<geometry_msgs::Vector3>(
        "geometry_msgs/Vector3  force\ngeometry_msgs/Vector3  position\nbool[] lock\n");
  }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.force, m.position, m.lock);
  }
};

}  // namespace raven2_trainer::ros_bridge::devices

RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::devices::OmniState)
RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::devices::ButtonEvent)
RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::devices::OmniFeedback)
RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::devices::DeviceFeedback)
