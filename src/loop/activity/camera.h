#pragma once

#include "loop/activity/activity.h"
#include "raven2_trainer/control/camera_orbit.h"

namespace raven2_trainer::loop {

/** The camera's pedal is held: the masters move the camera, both arms hold. */
class Camera final : public Activity {
 public:
  Camera(const CameraConfig& start, Stage* stage) noexcept : Activity(stage), orbit_(start) {}

  CameraState state() const noexcept { return orbit_.state(); }

  void enter(Mode before) noexcept override;
  void tick() noexcept override;
  PlanningAnswer request(const Request& request) noexcept override;

 private:
  void lead(PerArm<JointArray>* target) noexcept override;
  bool followsRobot() const noexcept override { return !stage_.arms.isApart(); }

  control::CameraOrbit orbit_;
  Mode from_{Mode::kPedalUp};  ///< what the mode was before
};

}  // namespace raven2_trainer::loop
