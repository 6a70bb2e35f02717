#pragma once

#include <string>

// Finds out which computers can reach our ROS nodes. ROS has no authentication: a computer that can reach a node can
// call it.

namespace raven2_trainer::ros_bridge {

/** URI of the master: the argument __master:=, or ROS_MASTER_URI, or http://localhost:11311. */
std::string masterUri(int argc, char** argv);

/**
 * Sets ROS_IP to 127.0.0.1 if the master at `host` is on this computer and neither ROS_IP nor ROS_HOSTNAME is set, so
 * that topics and services are not open to the network unasked. Not thread-safe.
 */
void keepToLoopback(const std::string& host);

/** True if roscpp serves topics and services to this computer only: its own rule, ROS_HOSTNAME=localhost or
 * ROS_IP=127.*. */
bool isLoopbackOnly();

/** May services and topics move an arm or do harm: to this computer always, to a network if the configuration says so.
 */
bool mayCommand(bool enable_remote_control);

}  // namespace raven2_trainer::ros_bridge
