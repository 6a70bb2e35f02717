#include "raven2_trainer/haptics/hand_model.h"

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {

HandModel::HandModel(const HandConfig& config) noexcept
    : stiffness_over_mass_(config.hand_stiffness / config.hand_mass),
      damping_over_mass_(config.hand_damping / config.hand_mass),
      inverse_mass_(1.0 / config.hand_mass) {}

void HandModel::step(const Eigen::Vector3d& force) noexcept {
  v_ += kTickSeconds * (inverse_mass_ * force - stiffness_over_mass_ * x_);
  v_ /= 1.0 + kTickSeconds * damping_over_mass_;
  x_ += kTickSeconds * v_;
}

}  // namespace raven2_trainer::haptics
