#include "ros/master_device_messages.h"

namespace raven2_trainer::ros_bridge::devices {

std::string withVector3(const char* text) {
  return std::string(text) + "\n" + std::string(80, '=') + "\nMSG: geometry_msgs/Vector3\n" +
         ros::message_traits::Definition<geometry_msgs::Vector3>::value();
}

}  // namespace raven2_trainer::ros_bridge::devices
