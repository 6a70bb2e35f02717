#include "loop/activity/returning.h"

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::loop {

using control::Event;

Returning::Returning(const PlannerConfig& limits, Trial* trial, Stage* stage) noexcept
    : Activity(stage), trial_(*trial), path_(limits.velocity_limit, limits.acceleration_limit) {}

void Returning::enter(Mode before) noexcept {
  Activity::enter(before);
  begin();
}

void Returning::begin() noexcept {
  const bool has_robot = stage_.robot.isThere();
  const bool has_goal = has_robot || trial_.store().isOpen();
  PerArm<JointArray> goal = has_robot  ? stage_.robot.joints()
                            : has_goal ? trial_.store().start()
                                       : stage_.arms.joints();
  for (const Arm arm : kArms) {
    const double opening = has_goal ? stage_.arms.openingKept(arm) : stage_.arms.opening(arm);
    kinematics::setJaws(kinematics::jawMidline(at(goal, arm)), opening, &at(goal, arm));
  }
  path_.start(stage_.arms.joints(), goal);
}

/** A repetition needs a new pedal-down: a pedal that is already down must come up first. */
void Returning::supervise() noexcept {
  if (!path_.isOver()) return;
  if (stage_.isAstray(path_.goal())) return begin();
  const bool repeats = trial_.store().isUnderWay();
  if (repeats && stage_.pedal.is_down) return;
  if (stage_.robot.isThere()) stage_.arms.meetRobot();  // else whatever robot comes is gone to
  stage_.arms.takeOpenings(path_.goal());
  if (repeats) return trial_.armRepeat();
  raise(Event::kReturned);
}

void Returning::lead(PerArm<JointArray>* target) noexcept {
  stage_.arms.want(path_.tick());
  for (const Arm arm : kArms)
    at(*target, arm) = stage_.arms.bringTo(arm, at(stage_.arms.wanted(), arm));
}

}  // namespace raven2_trainer::loop
