#pragma once

#include "loop/activity/trial.h"
#include "raven2_trainer/control/return_path.h"

namespace raven2_trainer::loop {

/** The model glides back to the robot through everything, with the pedal up; where there is no robot, to where the
 * trial began. A pedal-down waits for that. */
class Returning final : public Activity {
 public:
  Returning(const PlannerConfig& limits, Trial* trial, Stage* stage) noexcept;

  void enter(Mode before) noexcept override;
  void supervise() noexcept override;

 private:
  void begin() noexcept;
  void lead(PerArm<JointArray>* target) noexcept override;

  Trial& trial_;
  control::ReturnPath path_;
};

}  // namespace raven2_trainer::loop
