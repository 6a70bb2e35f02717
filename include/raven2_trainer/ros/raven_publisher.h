#pragma once

#include <memory>

#include "raven2_trainer/runtime/raven_server.h"

namespace raven2_trainer::ros_bridge {

/**
 * The virtual Raven's face to ROS, that of the real robot's `r2_control` (raven2.md 5):
 *
 *   /ravenstate      raven_2/raven_state, every control cycle
 *   /joint_states    sensor_msgs/JointState, 28 positions, at least 30 ms apart
 *   /raven_automove  raven_2/raven_automove, in
 *
 * and the start button of the emulated PLC as a service, `virtual_raven/press_start`. A thread of its own publishes
 * what the control loop leaves in a ring; a subscriber that takes nothing loses messages and delays nobody.
 */
class RavenPublisher {
 public:
  /** Call after connect(). @param[in] d4 [m] ArmGeometry::d4. */
  RavenPublisher(double d4, runtime::RavenServer* server);
  ~RavenPublisher();
  void start();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
