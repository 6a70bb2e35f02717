#pragma once

namespace raven2_trainer::ros_bridge {

/**
 * ros::init with our own signal handling; needs no master. Takes remappings out of argv. Nothing the second time.
 * Before other threads (it may set ROS_IP). @throw ConfigException if the master's URI is no http://HOST:PORT.
 */
void initNode(int argc, char** argv, const char* node);

}  // namespace raven2_trainer::ros_bridge
