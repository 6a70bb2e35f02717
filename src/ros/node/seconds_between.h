#pragma once

#include <ros/time.h>

#include <cstdint>

namespace raven2_trainer::ros_bridge {

/** [s] from one time to another, negative if it is earlier. A ros::Duration throws beyond 68 years, and messages of
 * others may have any stamp. */
inline double secondsBetween(const ros::Time& from, const ros::Time& to) noexcept {
  return static_cast<double>(static_cast<std::int64_t>(to.toNSec()) - static_cast<std::int64_t>(from.toNSec())) * 1e-9;
}

}  // namespace raven2_trainer::ros_bridge
