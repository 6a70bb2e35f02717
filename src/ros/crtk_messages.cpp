#include "ros/crtk_messages.h"

namespace raven2_trainer::ros_bridge::crtk {
namespace {

constexpr const char* kHeader = R"(
================================================================================
MSG: std_msgs/Header
)";
constexpr const char* kOperatingState = R"(std_msgs/Header header
string state
bool is_homed
bool is_busy
)";
constexpr const char* kStringStamped = R"(std_msgs/Header header
string string
)";

std::string withHeader(const char* text) {
  return std::string(text) + kHeader + ros::message_traits::Definition<std_msgs::Header>::value();
}

}  // namespace

const char* operatingStateDefinition() {
  static const std::string text = withHeader(kOperatingState);
  return text.c_str();
}

const char* stringStampedDefinition() {
  static const std::string text = withHeader(kStringStamped);
  return text.c_str();
}

}  // namespace raven2_trainer::ros_bridge::crtk
