#pragma once

#include <ros/time.h>

#include <cstdint>

#include "ros/bridge/messages.h"

namespace raven2_trainer::ros_bridge {

/** One stamp for all pictures of a state. Both eyes need equal stamps to be taken for a pair, and a picture that does
 * not change keeps its
 *  stamp; two readings of two clocks would differ. */
class PictureStamp {
 public:
  /** As stampOf(), of the first call with this `then_ns` in a row. */
  ros::Time of(std::int64_t then_ns, std::int64_t now_ns, const ros::Time& now) {
    if (then_ns != then_ns_ || then_ns <= 0) stamp_ = stampOf(then_ns, now_ns, now);
    then_ns_ = then_ns;
    return stamp_;
  }

 private:
  std::int64_t then_ns_{0};
  ros::Time stamp_;
};

}  // namespace raven2_trainer::ros_bridge
