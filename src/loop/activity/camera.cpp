#include "loop/activity/camera.h"

namespace raven2_trainer::loop {
namespace {

using control::Event;

/** The event by which releasing the camera's pedal goes back to mode `from`. */
Event cameraLeft(Mode from) noexcept {
  switch (traitsOf(from).practice) {
    case Practice::kSimulation:
      return Event::kCameraLeftAlone;
    case Practice::kTrial:
      return Event::kCameraLeftOnTape;
    default:
      return Event::kCameraLeft;
  }
}

}  // namespace

void Camera::enter(Mode before) noexcept {
  from_ = before;
  Activity::enter(before);
}

/** A pedal that is still down when the camera's goes up is pressed again in the same tick; not when silence took the
 *  camera from a surgeon who goes on moving it: then a new pedal-down is needed. */
PlanningAnswer Camera::request(const Request& request) noexcept {
  const auto pedal = static_cast<CameraPedal>(request.enabled);
  const bool is_moving = mode() == Mode::kCameraMoving;
  if ((pedal == CameraPedal::kPressed) == is_moving) return PlanningAnswer::kNotNow;
  if (!is_moving) return ask(Event::kCameraPressed);
  stage_.increments.drop();
  stage_.pedal.was_down = pedal == CameraPedal::kSilent && stage_.pedal.is_down;
  return ask(cameraLeft(from_));
}

void Camera::tick() noexcept {
  Vec3 mean_I{};
  for (const Vec3& dp : stage_.increments.dp_I) {
    for (std::size_t i = 0; i < mean_I.size(); ++i)
      mean_I[i] += 0.5 * dp[i];
  }
  orbit_.move(mean_I);
  stage_.useCommands();
  stage_.increments.drop();
}

void Camera::lead(PerArm<JointArray>* target) noexcept {
  if (followsRobot()) followRobot(target);
}

}  // namespace raven2_trainer::loop
