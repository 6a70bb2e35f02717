#include "python/under_way.h"

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::python {

void UnderWay::add(std::uint32_t sequence, const console::HandsCommand& command, bool may_move) {
  if (command.pedal && may_move) {
    Sent sent{sequence, {}};
    for (const Arm arm : kArms)
      at(sent.arms, arm) = {at(command.move_I, arm), at(command.turn_I, arm),
                            at(command.grasp, arm) - at(grasp_, arm)};
    sent_.push_back(sent);
  }
  grasp_ = command.grasp;
}

void UnderWay::arrived(std::uint32_t sequence) noexcept {
  while (!sent_.empty() && static_cast<std::int32_t>(sent_.front().sequence - sequence) <= 0)
    sent_.pop_front();
}

UnderWay::Motion UnderWay::of(Arm arm) const noexcept {
  Motion all;
  for (const Sent& sent : sent_) {
    const Motion& one = at(sent.arms, arm);
    all.move_I = toArray(Vector3(toEigen(all.move_I) + toEigen(one.move_I)));
    all.turn_I = toArray(Quaternion(toEigen(one.turn_I) * toEigen(all.turn_I)));
    all.grasp += one.grasp;
  }
  return all;
}

}  // namespace raven2_trainer::python
