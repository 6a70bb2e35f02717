#pragma once

#include <memory>

#include "raven2_trainer/ros/ros_face.h"

namespace raven2_trainer::ros_bridge {

/**
 * Holds a program's tie to the ROS master, from its own thread: nothing else ever waits for ROS.
 *
 * Looks for a master every 0.1 to 0.25 s with timed calls; with the first one it starts roscpp and the face. A master
 * that came back without knowing this node (another process, or its memory gone) gets all topics, services and
 * subscriptions again, which roscpp never does. Connections to subscribers stay meanwhile.
 *
 * The slave API's `shutdown` is refused with a fault: ROS knows no authentication, so anybody could end the node. Where
 * the master is on this computer and neither ROS_IP nor ROS_HOSTNAME is set, ROS_IP becomes 127.0.0.1. doc/ros.md.
 */
class Supervisor {
 public:
  /**
   * ros::init with our own signal handling; needs no master. One a process; before other threads (it may set ROS_IP).
   * `face` must outlive leave().
   * @throw ConfigException if the master's URI is no http://HOST:PORT.
   */
  Supervisor(int argc, char** argv, const char* node, RosFace* face);
  /** leave(1), if that was not called. */
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  void start();

  /** True once the face is started, ever. Any thread. */
  bool met() const noexcept;

  /** Asks the thread to end the face and roscpp, and returns at once: the program can end other parts
   * meanwhile. */
  void end() noexcept;

  /**
   * Ends the face and roscpp. Last in main: a master that hangs is not waited for longer than 0.5 s; then the process
   * ends here and now with `status`. @return `status`.
   */
  int leave(int status);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
