#pragma once

#include <Eigen/Core>

#include "raven2_trainer/haptics/haptics_config.h"

namespace raven2_trainer::haptics {

/**
 * Last station of a force on its way to a hand: never more than `max_force`, never changing faster than `max_slew`,
 * always finite, whatever is asked of it. It goes straight from the force given to the one asked for; what is not
 * finite counts as nothing. Real-time safe.
 */
class ForceLimiter {
 public:
  explicit ForceLimiter(const HapticGains& gains) noexcept : max_force_(gains.max_force), max_slew_(gains.max_slew) {}

  /**
   * @param[in] wanted [N] any frame, the same in every call.
   * @param[in] seconds [s] since the last call; a longer time counts as 1 ms, one that is not positive as none.
   * @return [N] the force to give now.
   */
  Eigen::Vector3d step(const Eigen::Vector3d& wanted, double seconds) noexcept;

  /** Goes on from a force that was given. */
  void resume(const Eigen::Vector3d& force) noexcept { force_ = force; }
  const Eigen::Vector3d& force() const noexcept { return force_; }  ///< [N] given last

 private:
  double max_force_, max_slew_;
  Eigen::Vector3d force_{Eigen::Vector3d::Zero()};
};

}  // namespace raven2_trainer::haptics
