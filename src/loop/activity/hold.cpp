#include "loop/activity/hold.h"

namespace raven2_trainer::loop {

using control::Event;

void Hold::supervise() noexcept {
  if (mode() == Mode::kPedalUp && stage_.mustReturn()) raise(Event::kReturnWanted);
}

void Hold::lead(PerArm<JointArray>* target) noexcept {
  if (followsRobot()) followRobot(target);
}

/** The robot is sent pedal-up in this tick, and until the stop is cleared: ITP has no more than that. */
PlanningAnswer Hold::request(const Request& request) noexcept {
  if (request.kind == RequestKind::kClearStop) return clearStop();
  if (request.kind != RequestKind::kEmergencyStop) return PlanningAnswer::kNotNow;
  stage_.stop_asked = true;
  raise(Event::kEmergencyStop);
  return PlanningAnswer::kAccepted;
}

/** A stop of the robot ends when it leaves E-STOP; that of a robot that is gone, when the surgeon's side clears it. */
PlanningAnswer Hold::clearStop() noexcept {
  const bool robot_is_gone = stage_.stopped_by_robot && stage_.robot.isLost();
  if (!stage_.stop_asked && !robot_is_gone) return PlanningAnswer::kNotNow;
  if (!stage_.pedal.isUp() || !stage_.arms.world().healthy()) return PlanningAnswer::kNotNow;
  stage_.stop_asked = false;
  if (robot_is_gone) stage_.stopped_by_robot = false;
  if (!stage_.stopped_by_robot) raise(Event::kStopCleared);
  return PlanningAnswer::kAccepted;
}

}  // namespace raven2_trainer::loop
