#pragma once

#include <functional>
#include <memory>

#include "raven2_trainer/core/state.h"

namespace raven2_trainer::ros_bridge {

/**
 * What the real robot publishes itself: /joint_states, positions only, every 30 ms (raven2.md 5.4); its 14 measured
 * joints, not yet the 14 desired ones (suffix 2), which the state frame does not carry. And the start button of the
 * emulated PLC as a service, `virtual_raven/press_start`.
 */
class RavenPublisher {
 public:
  /** Call after connect(). `state` gives the newest state, `press_start` presses the button; both from any thread. */
  RavenPublisher(double d4, std::function<RobotState()> state, std::function<void()> press_start);
  ~RavenPublisher();
  void start();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
