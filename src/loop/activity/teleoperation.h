#pragma once

#include "loop/activity/activity.h"

namespace raven2_trainer::loop {

/** The masters move model and robot, or the model alone: teleoperating, simulating. */
class Teleoperation final : public Activity {
 public:
  explicit Teleoperation(Stage* stage) noexcept : Activity(stage) {}

  void tick() noexcept override { aimByHand(); }
  PlanningAnswer request(const Request& request) noexcept override;

 private:
  void push(const Request& request) noexcept;
};

}  // namespace raven2_trainer::loop
