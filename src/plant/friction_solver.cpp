#include "plant/friction_solver.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::plant {
namespace {

constexpr std::size_t kMaxSweeps = 60;
constexpr double kConverged = 1e-7;  // [rad/s] of a motor: a thousandth of a count in a second

}  // namespace

double FrictionSolver::sweepFriction(const Matrix& admittance, const Vector& limit) noexcept {
  double change = 0.0;
  for (Eigen::Index j = 0; j < kRates; ++j) {
    if (limit[j] == 0.0) continue;
    const double gain = admittance(j, j);
    const double wanted = std::clamp(impulse_[j] - rate_[j] / gain, -limit[j], limit[j]);
    const double delta = wanted - impulse_[j];
    impulse_[j] = wanted;
    rate_.noalias() += admittance.col(j) * delta;
    change = std::max(change, std::abs(delta * gain));
  }
  return change;
}

double FrictionSolver::sweepStops(const Matrix& admittance, const Stops& stops, std::size_t stop_count) noexcept {
  double change = 0.0;
  for (std::size_t k = 0; k < stop_count; ++k) {
    const Stop& stop = stops[k];
    const auto column = admittance.col(stop.coordinate);
    const double missing = stop.least_rate - stop.sign * rate_[stop.coordinate];
    const double wanted = std::max(0.0, push_[k] + missing / column[stop.coordinate]);
    const double delta = wanted - push_[k];
    push_[k] = wanted;
    rate_.noalias() += column * (stop.sign * delta);
    change = std::max(change, std::abs(delta) * column.cwiseAbs().maxCoeff());
  }
  return change;
}

FrictionSolver::Vector FrictionSolver::solve(const Matrix& admittance,
                                             const Vector& free,
                                             const Vector& limit,
                                             const Stops& stops,
                                             std::size_t stop_count) noexcept {
  impulse_ = impulse_.cwiseMax(-limit).cwiseMin(limit);
  rate_ = free;
  for (Eigen::Index j = 0; j < kRates; ++j) {
    if (impulse_[j] != 0.0) rate_.noalias() += admittance.col(j) * impulse_[j];
  }
  push_.fill(0.0);
  for (iterations_ = 1; iterations_ <= kMaxSweeps; ++iterations_) {
    const double friction = sweepFriction(admittance, limit);
    if (std::max(friction, sweepStops(admittance, stops, stop_count)) < kConverged) break;
  }
  for (Eigen::Index j = 0; j < kRates; ++j) {
    if (std::abs(impulse_[j]) < limit[j]) rate_[j] = 0.0;  // held: exactly still
  }
  return rate_;
}

}  // namespace raven2_trainer::plant
