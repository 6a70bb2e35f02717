#include "raven2_trainer/detector/identify.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::detector {
namespace {

constexpr std::size_t kHalf = 8;       // [cycles] of the second difference
constexpr double kMoving = 3.0;        // [rad/s] about two counts per cycle
constexpr std::size_t kFewest = 1000;  // rows
constexpr int kUnknowns = 7;           // torque, velocity, sign, one, three joints

/** Mean of the torques around the start of cycle `centre`, weighted as a second difference weights accelerations. A
 *  torque that is constant from cycle to cycle puts half of its effect on either side. */
double meanTorque(const std::vector<AxisSample>& stretch, std::size_t centre) {
  double sum = 0.0;
  for (std::size_t i = centre + 1 - kHalf; i < centre + kHalf; ++i) {
    const auto weight = static_cast<double>(kHalf - (i > centre ? i - centre : centre - i));
    sum += weight * 0.5 * (stretch[i - 1].torque + stretch[i].torque);
  }
  return sum / static_cast<double>(kHalf * kHalf);
}

}  // namespace

void AxisFit::add(const std::vector<AxisSample>& stretch) {
  const double span = static_cast<double>(kHalf) * kTickSeconds;
  for (std::size_t c = kHalf; c + kHalf < stretch.size(); ++c) {
    const double before = stretch[c - kHalf].motor, here = stretch[c].motor, after = stretch[c + kHalf].motor;
    const double velocity = (after - before) / (2.0 * span);
    if (std::abs(velocity) < kMoving) continue;
    rows_.push_back({(after - 2.0 * here + before) / (span * span), meanTorque(stretch, c), velocity, stretch[c].q});
  }
}

DetectorAxis AxisFit::solve() const {
  if (rows_.size() < kFewest) throw Exception("detector: an axis moved for less than 1 s in all, nothing to fit");
  Eigen::MatrixXd A(static_cast<Eigen::Index>(rows_.size()), kUnknowns);
  Eigen::VectorXd b(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    A.row(i) << row.torque, row.velocity, std::copysign(1.0, row.velocity), 1.0, row.q[0], row.q[1], row.q[2];
    b[i] = row.acceleration;
  }
  const Eigen::VectorXd x = A.colPivHouseholderQr().solve(b);
  DetectorAxis axis;
  axis.inertia = 1.0 / x[0];
  axis.viscous = -x[1] * axis.inertia;
  axis.coulomb = -x[2] * axis.inertia;
  axis.offset = -x[3] * axis.inertia;
  for (std::size_t k = 0; k < kDetectorAxes; ++k)
    axis.gravity[k] = -x[4 + static_cast<Eigen::Index>(k)] * axis.inertia;
  if (!(axis.inertia > 0.0 && axis.viscous > 0.0 && axis.coulomb > 0.0)) {
    throw Exception("detector: the fit of an axis gives an inertia or a friction below zero");
  }
  return axis;
}

double AxisFit::explained(const DetectorAxis& axis) const {
  double sum = 0.0, square = 0.0, rest = 0.0;
  for (const Row& row : rows_) {
    double net = row.torque - axis.offset - axis.viscous * row.velocity - std::copysign(axis.coulomb, row.velocity);
    for (std::size_t k = 0; k < kDetectorAxes; ++k)
      net -= axis.gravity[k] * row.q[k];
    const double error = row.acceleration - net / axis.inertia;
    sum += row.acceleration;
    square += row.acceleration * row.acceleration;
    rest += error * error;
  }
  const auto n = static_cast<double>(std::max<std::size_t>(rows_.size(), 1));
  const double variance = square - sum * sum / n;
  return variance > 0.0 ? 1.0 - rest / variance : 0.0;
}

TailPercentile::TailPercentile(double percentile, std::size_t most)
    : share_(1.0 - percentile / 100.0),
      kept_(static_cast<std::size_t>(std::ceil(share_ * static_cast<double>(most))) + 1) {}

void TailPercentile::add(double value) {
  ++count_;
  if (heap_.size() == kept_) {
    if (value <= heap_.front()) return;
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    heap_.back() = value;
  } else {
    heap_.push_back(value);
  }
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

double TailPercentile::value() const {
  if (heap_.empty()) return 0.0;
  std::vector<double> sorted = heap_;
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  const auto above =
      static_cast<std::size_t>(std::floor(share_ * static_cast<double>(count_)));  // values that may exceed it
  return sorted[std::min(above, sorted.size() - 1)];
}

}  // namespace raven2_trainer::detector
