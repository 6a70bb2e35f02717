// Values that a simulation copies for its State.

#include <mutex>

#include "python/simulation.h"

namespace raven2_trainer::python {

ContactList Simulation::contacts() const {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  return stack_->shared()->contacts.load();
}

std::vector<std::string> Simulation::bodyNames() const {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  return stack_->bodyNames();
}

PerArm<JointArray> Simulation::trueJoints() const {
  const std::lock_guard<std::recursive_mutex> lock(mutex_);
  return {stack_->trueJoints(Arm::kGold), stack_->trueJoints(Arm::kGreen)};
}

}  // namespace raven2_trainer::python
