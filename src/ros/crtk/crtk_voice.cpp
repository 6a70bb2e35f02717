#include "ros/crtk/crtk_voice.h"

#include <ros/time.h>

#include "ros/node/topic.h"

namespace raven2_trainer::ros_bridge {
CrtkVoice::CrtkVoice(ros::NodeHandle* node, const std::string& name)
    : publishers_{node->advertise<crtk::StringStamped>(name + "/info", kQueue),
                  node->advertise<crtk::StringStamped>(name + "/warning", kQueue),
                  node->advertise<crtk::StringStamped>(name + "/error", kQueue)} {}

void CrtkVoice::say(CrtkLevel level, const std::string& sentence) {
  crtk::StringStamped message;
  message.header.stamp = ros::Time::now();
  message.string = sentence;
  publishers_[static_cast<std::size_t>(level)].publish(message);
}

void CrtkVoice::complain(CrtkLevel level, const std::string& about, const std::string& sentence, std::int64_t now_ns) {
  std::optional<std::string> passed;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    passed = patience_.pass(about, sentence, now_ns);
  }
  if (passed) say(level, *passed);
}

}  // namespace raven2_trainer::ros_bridge
