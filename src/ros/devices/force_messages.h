#pragma once

#include <geometry_msgs/WrenchStamped.h>
#include <ros/time.h>

#include <string>

#include "raven2_trainer/console/master.h"
#include "ros/devices/master_device_messages.h"

// A device's force in the message of its driver. DeviceForce is in the device's axes and the driver's units already.

namespace raven2_trainer::ros_bridge::devices {

inline geometry_msgs::Vector3 toMessage(const Vec3& v) {
  geometry_msgs::Vector3 m;
  m.x = v[0];
  m.y = v[1];
  m.z = v[2];
  return m;
}

// `position`: a driver that locks the device locks it where it is, and does not pull.

inline void fill(const DeviceForce& out, const std::string& /*frame*/, OmniFeedback* message) {
  message->force = toMessage(out.force);
  message->position = toMessage(out.position);
}

inline void fill(const DeviceForce& out, const std::string& /*frame*/, DeviceFeedback* message) {
  message->force = toMessage(out.force);
  message->position = toMessage(out.position);
  message->lock.assign(3, 0);
}

inline void fill(const DeviceForce& out, const std::string& frame, geometry_msgs::WrenchStamped* message) {
  message->header.stamp = ros::Time::now();
  message->header.frame_id = frame;
  message->wrench.force = toMessage(out.force);
}

}  // namespace raven2_trainer::ros_bridge::devices
