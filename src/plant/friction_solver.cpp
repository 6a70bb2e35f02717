#include "plant/friction_solver.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::plant {
namespace {

constexpr std::size_t kMaxSweeps = 60;
constexpr double kConverged = 1e-7;  // [rad/s] of a motor: a thousandth of a count in a second

}  // namespace

FrictionSolver::Vector FrictionSolver::solve(const Matrix& W,
                                             const Vector& free,
                                             const Vector& limit,
                                             const std::array<Stop, kJointCount>& stops,
                                             std::size_t stop_count) noexcept {
  impulse_ = impulse_.cwiseMax(-limit).cwiseMin(limit);
  Vector velocity = free + W * impulse_;
  std::array<double, kJointCount> push{};
  std::array<Vector, kJointCount> response;
  for (std::size_t k = 0; k < stop_count; ++k)
    response[k].noalias() = W * stops[k].direction;

  for (iterations_ = 1; iterations_ <= kMaxSweeps; ++iterations_) {
    double change = 0.0;
    for (Eigen::Index j = 0; j < 7; ++j) {
      const double wanted = std::clamp(impulse_[j] - velocity[j] / W(j, j), -limit[j], limit[j]);
      const double delta = wanted - impulse_[j];
      impulse_[j] = wanted;
      velocity.noalias() += W.col(j) * delta;
      change = std::max(change, std::abs(delta * W(j, j)));
    }
    for (std::size_t k = 0; k < stop_count; ++k) {
      const double gain = stops[k].direction.dot(response[k]);
      const double rate = stops[k].direction.dot(velocity);
      const double wanted = std::max(0.0, push[k] - (rate - stops[k].least_rate) / gain);
      velocity.noalias() += response[k] * (wanted - push[k]);
      change = std::max(change, std::abs((wanted - push[k]) * response[k].cwiseAbs().maxCoeff()));
      push[k] = wanted;
    }
    if (change < kConverged) break;
  }
  for (Eigen::Index j = 0; j < 7; ++j) {
    if (std::abs(impulse_[j]) < limit[j]) velocity[j] = 0.0;  // held: exactly still
  }
  return velocity;
}

}  // namespace raven2_trainer::plant
