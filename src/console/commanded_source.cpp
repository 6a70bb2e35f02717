#include "raven2_trainer/console/commanded_source.h"

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {

CommandedSource::CommandedSource(const ConsoleConfig& config, const PerArm<double>& opening) noexcept
    : scale_(config.scale) {
  command_.grasp = opening;
}

void CommandedSource::set(const HandsCommand& command) noexcept {
  command_ = command;
}

Intent CommandedSource::tick(const Senses& senses) {
  may_move_ = senses.may_move;
  sequence_ = senses.sequence;
  done_ = command_;
  intent_.pedal = command_.pedal && may_move_;
  intent_.grasp = command_.grasp;
  for (const Arm arm : kArms) {
    const Vector3 moved = toEigen(at(intent_.hand_I, arm)) + toEigen(at(command_.move_I, arm)) / scale_;
    at(intent_.hand_I, arm) = toArray(moved);
    const Quaternion turned = toEigen(at(command_.turn_I, arm)) * toEigen(at(intent_.turn_I, arm));
    at(intent_.turn_I, arm) = toArray(turned.normalized());
  }
  command_.move_I = {};
  command_.turn_I = {kIdentityQuat, kIdentityQuat};
  return intent_;
}

}  // namespace raven2_trainer::console
