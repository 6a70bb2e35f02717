#pragma once

#include <string>
#include <vector>

namespace raven2_trainer::ros_bridge {

/** Topics and services of one program. It exists without ROS; the Supervisor starts it when a master is there. */
class RosFace {
 public:
  virtual ~RosFace() = default;
  /** Topics and services appear. Call it after ros::start(), or after stop(); a slow master may block it. */
  virtual void start() = 0;
  /** They go and their threads end. Safe without start(). */
  virtual void stop() = 0;
  /** Resolved names of the services offered now: roscpp does not list them, and a restarted master must be informed. */
  virtual std::vector<std::string> services() const = 0;
};

}  // namespace raven2_trainer::ros_bridge
