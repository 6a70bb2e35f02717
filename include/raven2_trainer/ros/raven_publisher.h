#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/robot/raven_server.h"
#include "raven2_trainer/ros/ros_face.h"

namespace raven2_trainer::ros_bridge {

/**
 * The virtual Raven's face to ROS, that of the real robot's `r2_control` (raven2.md 5):
 *
 *   /ravenstate      raven_2/raven_state, every control cycle
 *   /joint_states    sensor_msgs/JointState, 28 positions, at least 30 ms apart
 *   /raven_automove  raven_2/raven_automove, in
 *
 * and the start button of the emulated PLC as a service, `virtual_raven/press_start`. A separate thread publishes
 * the control loop's states from a ring. A subscriber that takes nothing loses messages and delays nobody.
 * /raven_automove and press_start, which move the arm, are offered to a network only with runtime.yaml's
 * enable_remote_control.
 */
class RavenPublisher : public RosFace {
 public:
  /** `server` must outlive this. */
  RavenPublisher(const ArmGeometry& geometry, bool enable_remote_control, robot::RavenServer* server);
  ~RavenPublisher() override;
  RavenPublisher(const RavenPublisher&) = delete;
  RavenPublisher& operator=(const RavenPublisher&) = delete;

  void start() override;
  void stop() override;
  std::vector<std::string> services() const override;

  /** Messages of /ravenstate that were lost because nobody took them in time, since start(). Any thread. */
  std::uint64_t lost() const noexcept;

 private:
  struct Impl;
  const double d4_;
  const bool enable_remote_control_;
  robot::RavenServer& server_;
  std::atomic<std::uint64_t> lost_before_{0};  ///< reports that nobody took while there was no master
  std::unique_ptr<Impl> impl_;                 ///< between start() and stop()
};

}  // namespace raven2_trainer::ros_bridge
