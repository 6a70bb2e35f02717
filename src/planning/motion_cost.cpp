#include "planning/motion_cost.h"

#include <cmath>

#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

constexpr int kLast = 16;  // number of intervals; even, as the quadrature formula below wants
constexpr int kNodes = kLast + 1;
using Row = Eigen::Matrix<double, 1, kNodes>;
using Square = Eigen::Matrix<double, kNodes, kNodes>;

/** Everything about the nodes t_i = (1 - cos(pi i / 16)) / 2 in [0, 1] that does not depend on the motion. */
struct Nodes {
  Row blend;    // quintic at the nodes
  Row weights;  // of the quadrature
  Square D2;    // values to second derivatives
};

/** Chebyshev differentiation (Trefethen, Spectral Methods in MATLAB, 2000, ch. 6), squared, scaled to [0, 1]. */
Square secondDerivative() {
  Square D = Square::Zero();
  const auto end = [](int i) { return i == 0 || i == kLast ? 2.0 : 1.0; };
  const auto x = [](int i) { return -std::cos(kPi * i / kLast); };
  for (int i = 0; i < kNodes; ++i) {
    for (int j = 0; j < kNodes; ++j) {
      if (i != j) D(i, j) = end(i) / end(j) * ((i + j) % 2 == 0 ? 1.0 : -1.0) / (x(i) - x(j));
    }
    D(i, i) = -D.row(i).sum();
  }
  return 4.0 * D * D;
}

/** Clenshaw-Curtis weights (same book, ch. 12), scaled to [0, 1]. */
Row quadratureWeights() {
  Row weights;
  for (int i = 0; i < kNodes; ++i) {
    double sum = 1.0;
    for (int k = 1; k <= kLast / 2; ++k) {
      const double b = 2 * k == kLast ? 1.0 : 2.0;
      sum -= b / (4.0 * k * k - 1.0) * std::cos(2.0 * k * i * kPi / kLast);
    }
    weights(i) = sum / kLast * (i == 0 || i == kLast ? 0.5 : 1.0);
  }
  return weights;
}

const Nodes& nodes() {
  static const Nodes made = [] {
    Nodes n;
    for (int i = 0; i < kNodes; ++i)
      n.blend(i) = control::quinticBlend((1.0 - std::cos(kPi * i / kLast)) / 2);
    n.weights = quadratureWeights();
    n.D2 = secondDerivative();
    return n;
  }();
  return made;
}

}  // namespace

double edgeDuration(const PlannerConfig& config, const JointArray& a, const JointArray& b) noexcept {
  JointArray delta{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    delta[j] = b[j] - a[j];
  return control::quinticDuration(delta, config.velocity_limit, config.acceleration_limit);
}

double tipEffort(const ArmGeometry& geometry,
                 Arm arm,
                 const JointArray& a,
                 const JointArray& b,
                 double duration) noexcept {
  if (duration <= 0.0) return 0.0;
  if (b < a) return tipEffort(geometry, arm, b, a, duration);  // same rounding both ways
  const Nodes& n = nodes();
  Eigen::Matrix<double, kNodes, 3> tips;
  const Vector3 origin = kinematics::forward(geometry, arm, a).p;  // small numbers differentiate best
  for (int i = 0; i < kNodes; ++i) {
    JointArray q{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] = a[j] + n.blend(i) * (b[j] - a[j]);
    tips.row(i) = (kinematics::forward(geometry, arm, q).p - origin).transpose();
  }
  const Eigen::Matrix<double, kNodes, 1> squares = (n.D2 * tips).rowwise().squaredNorm();
  return n.weights.dot(squares) / (duration * duration * duration);
}

double edgeCost(const ArmGeometry& geometry,
                const PlannerConfig& config,
                const JointSpace& space,
                Arm arm,
                const UnitState& a,
                const UnitState& b) noexcept {
  double cost = config.eta_length * distance(a, b);
  if (config.eta_acceleration > 0.0) {
    const JointArray from = space.toJoints(a), to = space.toJoints(b);
    cost += config.eta_acceleration * tipEffort(geometry, arm, from, to, edgeDuration(config, from, to));
  }
  return cost;
}

}  // namespace raven2_trainer::planning
