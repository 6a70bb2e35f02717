#include <ros/init.h>
#include <ros/master.h>

#include "raven2_trainer/ros/ros_bridge.h"

namespace raven2_trainer::ros_bridge {

bool connect(int argc, char** argv, const char* node) {
  // Our mains wait for signals themselves: the force goes to zero before anything else ends.
  ros::init(argc, argv, node, ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  return ros::master::check();  // a NodeHandle would wait for ever without a master
}

}  // namespace raven2_trainer::ros_bridge
