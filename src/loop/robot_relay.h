#pragma once

#include "loop/loop_faults.h"
#include "loop/stage.h"

namespace raven2_trainer::loop {

/** Sends the robot, in every tick, the increments that moved the model, or pedal-up, with the changes that faults make.
 * One thread; real-time safe. */
class RobotRelay {
 public:
  RobotRelay(LoopFaults* faults, Stage* stage) noexcept : faults_(*faults), stage_(*stage) {}

  void tick() noexcept;
  /** [rad; m] The robot's set points, as far as they are known here. The model may move without the robot: along a plan
   * that it tracks, in a trial, in a replay. With the pedal up the set point is where the robot is. */
  const PerArm<JointArray>& setPoints() noexcept;

 private:
  void send(const RelayPacket& packet) noexcept;

  LoopFaults& faults_;
  Stage& stage_;
  PerArm<JointArray> q_d_{};
  std::uint32_t sequence_{0};
  bool is_in_step_{false};  ///< our numbering follows the one the robot echoed
};

}  // namespace raven2_trainer::loop
