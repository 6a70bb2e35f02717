#pragma once

#include <functional>
#include <memory>

#include "raven2_trainer/core/state.h"

namespace raven2_trainer::ros_bridge {

/**
 * What the real robot publishes itself: /joint_states, 28 names (measured, then desired with suffix 2), positions only,
 * every 30 ms (raven2.md 5.4); and the start button as a service, `virtual_raven/press_start`. The desired ones are the
 * measured ones until the state frame carries them.
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
