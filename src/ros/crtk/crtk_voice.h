#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <array>
#include <mutex>
#include <string>

#include "ros/crtk/crtk_messages.h"
#include "ros/crtk/crtk_words.h"

namespace raven2_trainer::ros_bridge {

/** An arm's `info`, `warning` and `error`. Any thread. */
class CrtkVoice {
 public:
  /** @param[in] name of the arm's namespace. */
  CrtkVoice(ros::NodeHandle* node, const std::string& name);

  void say(CrtkLevel level, const std::string& sentence);
  /** At most once a second of what is `about` the same. @param[in] now_ns [ns] CLOCK_MONOTONIC. */
  void complain(CrtkLevel level, const std::string& about, const std::string& sentence, std::int64_t now_ns);

 private:
  std::array<ros::Publisher, 3> publishers_;  // by CrtkLevel
  std::mutex mutex_;                          // guards what follows
  CrtkPatience patience_;
};

}  // namespace raven2_trainer::ros_bridge
