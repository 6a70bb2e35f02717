#pragma once

#include <Eigen/Core>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::plant {

/**
 * Velocities after one sub-step under dry friction and hard stops, as a box-constrained complementarity problem
 * solved by projected Gauss-Seidel with warm start: an axis whose friction can hold it gets velocity exactly zero
 * (no chatter, no creep), any other is slowed by the full friction. Real-time safe.
 */
class FrictionSolver {
 public:
  using Vector = Eigen::Matrix<double, 7, 1>;
  using Matrix = Eigen::Matrix<double, 7, 7>;

  /** Axis `row` of the joint coordinates may not be slower than `least_rate` (hard stop ahead). */
  struct Stop {
    Vector direction;     ///< row times velocity = rate towards the inside
    double least_rate{};  ///< [rad/s; m/s] negative while there is still way to the stop
  };

  /**
   * @param[in] W inverse of the inertia matrix, [rad/s per Nms].
   * @param[in] free velocity without friction. @param[in] limit [Nms] friction impulse of each axis.
   * @param[in] stops, stop_count active hard stops.
   */
  Vector solve(const Matrix& W,
               const Vector& free,
               const Vector& limit,
               const std::array<Stop, kJointCount>& stops,
               std::size_t stop_count) noexcept;

  std::size_t iterations() const noexcept { return iterations_; }

 private:
  Vector impulse_{Vector::Zero()};
  std::size_t iterations_{0};
};

}  // namespace raven2_trainer::plant
