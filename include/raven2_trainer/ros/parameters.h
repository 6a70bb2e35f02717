#pragma once

#include "raven2_trainer/config/overrides.h"

namespace raven2_trainer::ros_bridge {

/**
 * The node's private parameters: /raven2_simulator/haptics/tolerance overrides haptics/tolerance. Those of the
 * arguments (`_haptics/tolerance:=0.005`), of a launch file, and whatever else the master has under the node's name.
 * None without a master, which is said on stderr if the arguments speak of ROS (NAME:=VALUE).
 *
 * Does what Supervisor does first (ros::init), so with the same arguments, before it and before other threads.
 * @throw ConfigException for a parameter of a type that YAML does not have, an invalid URI of a master, or a master
 * that answers and then does not give the parameters: they are never left out silently.
 */
config::Overrides nodeParameters(int argc, char** argv, const char* node);

/**
 * Parameters change what the daemon does, so they are commands: on a node open to a network they are refused unless the
 * file allows commands from there (`enable_remote_control`). After nodeParameters().
 * @throw ConfigException naming the first.
 */
void checkParameters(const config::Overrides& overrides, bool enable_remote_control);

}  // namespace raven2_trainer::ros_bridge
