#pragma once

#include <ros/time.h>

#include <cstdint>
#include <functional>

namespace raven2_trainer::ros_bridge {

/** One moment by two clocks. */
struct CrtkMoment {
  std::int64_t monotonic_ns{};
  ros::Time ros;
};

/** Reads both clocks again if the thread was interrupted between them, a few times at most: the time in between would
 * shift a stamp. @param[in] monotonic [ns]. */
CrtkMoment momentOf(const std::function<std::int64_t()>& monotonic, const std::function<ros::Time()>& ros);
/** By CLOCK_MONOTONIC and ros::Time::now(). */
CrtkMoment momentNow();

/** Stamps of a device's states. They increase, even if the clock of ROS does not: rosbag and tf rely on that. */
class CrtkStamp {
 public:
  /** As stampOf(), but after the last one; unless somebody has set the clock back. @param[in] then_ns [ns] monotonic.
   */
  ros::Time of(std::int64_t then_ns, const CrtkMoment& now);

 private:
  ros::Time last_;
};

}  // namespace raven2_trainer::ros_bridge
