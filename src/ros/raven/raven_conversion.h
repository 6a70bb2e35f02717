#pragma once

#include <sensor_msgs/JointState.h>

#include <optional>

#include "raven2_trainer/raven/raven_report.h"
#include "raven2_trainer/robot/raven_automove.h"
#include "ros/raven/raven_messages.h"

// The virtual Raven's cycle in the messages of the real robot's package: units, order and signs as there.

namespace raven2_trainer::ros_bridge {

/** All but header and dt. Angles in degrees, metres times 180 / pi as well (raven2.md 5.2). */
void fillRavenState(const RavenReport& report, raven_2::RavenState* message);

/** 14 measured joints, then the 14 wanted ones with suffix 2; positions only (raven2.md 5.4). */
sensor_msgs::JointState ravenJointState(const RavenReport& report, double d4, const ros::Time& stamp);

/** Whole micrometres, truncated as the robot does and held in 32 bits; nothing if a number is not finite. */
std::optional<RavenAutomove> toAutomove(const raven_2::RavenAutomove& message);

/** An arm's joints out of an array by channel. */
template <typename Channels>
JointArray jointsOf(const Channels& channels, Arm arm) {
  JointArray joints{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const std::size_t slot = j <= kInsertion ? j : j + 1;  // slot 3 is not connected
    joints[j] = static_cast<double>(channels[8 * index(arm) + slot]);
  }
  return joints;
}

}  // namespace raven2_trainer::ros_bridge
