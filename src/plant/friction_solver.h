#pragma once

#include <Eigen/Core>
#include <array>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::plant {

/**
 * Velocities after one sub-step under dry friction and hard stops, as a box-constrained complementarity problem
 * solved by projected Gauss-Seidel with warm start. An axis whose friction can hold it gets velocity exactly zero
 * (no chatter, no creep). Any other is slowed by the full friction. Works on the rates of an arm: seven motors, then
 * seven joints; whether these are independent (elastic cables) or not (rigid) is in the admittance. Real-time safe.
 */
class FrictionSolver {
 public:
  static constexpr int kRates = 2 * static_cast<int>(kJointCount);
  using Vector = Eigen::Matrix<double, kRates, 1>;
  using Matrix = Eigen::Matrix<double, kRates, kRates>;

  /** sign x rate[coordinate] may not fall below `least_rate` (hard stop ahead). */
  struct Stop {
    Eigen::Index coordinate{};
    double sign{};
    double least_rate{};  ///< [rad/s; m/s] negative while there is still way to the stop
  };
  using Stops = std::array<Stop, kJointCount>;

  /**
   * @param[in] admittance rates by impulses, symmetric, [rad/s per Nms].
   * @param[in] free rates without friction. @param[in] limit [Nms] friction impulse of each coordinate.
   * @param[in] stops, stop_count active hard stops.
   */
  Vector solve(const Matrix& admittance,
               const Vector& free,
               const Vector& limit,
               const Stops& stops,
               std::size_t stop_count) noexcept;

  /** Forgets the impulses of the last call. */
  void reset() noexcept { impulse_.setZero(); }

  std::size_t iterations() const noexcept { return iterations_; }

 private:
  double sweepFriction(const Matrix& admittance, const Vector& limit) noexcept;
  double sweepStops(const Matrix& admittance, const Stops& stops, std::size_t stop_count) noexcept;

  Vector impulse_{Vector::Zero()};
  Vector rate_{Vector::Zero()};
  std::array<double, kJointCount> push_{};
  std::size_t iterations_{0};
};

}  // namespace raven2_trainer::plant
