#pragma once

#include "loop/activity/activity.h"

namespace raven2_trainer::loop {

/** Nothing moves, but that with the pedal up the model follows the robot: waiting, pedal_up, stopped, paused,
 *  simulation_held. */
class Hold final : public Activity {
 public:
  explicit Hold(Stage* stage) noexcept : Activity(stage) {}

  void supervise() noexcept override;
  PlanningAnswer request(const Request& request) noexcept override;

 private:
  void lead(PerArm<JointArray>* target) noexcept override;
  PlanningAnswer clearStop() noexcept;
};

}  // namespace raven2_trainer::loop
