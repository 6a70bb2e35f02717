#pragma once

#include <Eigen/Core>

#include "raven2_trainer/haptics/hand_config.h"

namespace raven2_trainer::haptics {

/**
 * A hand that holds its position like a mass on a spring and damper, pushed by the haptic force:
 * m x'' = -k x - b x' + F on each axis. Stepped at 1 kHz with the semi-implicit Euler rule, the damping taken
 * implicitly, so that it is stable for every mass and damping the configuration allows. Axes are those of the force.
 * Real-time safe.
 */
class HandModel {
 public:
  explicit HandModel(const HandConfig& config) noexcept;

  /** One millisecond under `force` [N]. */
  void step(const Eigen::Vector3d& force) noexcept;

  /** [m] from where the hand wants to be. */
  const Eigen::Vector3d& deflection() const noexcept { return x_; }

 private:
  double stiffness_over_mass_, damping_over_mass_, inverse_mass_;
  Eigen::Vector3d x_{0, 0, 0};  ///< [m]
  Eigen::Vector3d v_{0, 0, 0};  ///< [m/s]
};

}  // namespace raven2_trainer::haptics
