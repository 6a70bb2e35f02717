#include "raven2_trainer/training/enclosing_sphere.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/QR>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::training {

namespace {

constexpr std::uint64_t kSeed = 1991;
constexpr double kSlack = 1e-9;  // [-] of the radius: a point of the boundary must not fall out by rounding

struct Ball {
  Vector3 centre{Vector3::Zero()};
  double squared_radius{-1.0};  ///< negative: of no points

  bool holds(const Vector3& point) const {
    return (point - centre).squaredNorm() <= squared_radius * (1.0 + kSlack) && squared_radius >= 0.0;
  }
};

/** Up to four points that lie on the sphere. */
struct Boundary {
  std::array<Vector3, 4> points;
  std::size_t count{0};

  Boundary with(const Vector3& point) const {
    Boundary more = *this;
    more.points[more.count++] = point;
    return more;
  }
};

/**
 * Smallest sphere through all points of the boundary. Its centre lies in their plane: c = p0 + D a with
 * 2 D^T D a = diag(D^T D). Points on one line or circle leave directions open; the least a closes them.
 */
Ball throughAll(const Boundary& boundary) {
  if (boundary.count == 0) return {};
  const Vector3& first = boundary.points[0];
  if (boundary.count == 1) return {first, 0.0};
  const auto others = static_cast<Eigen::Index>(boundary.count) - 1;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> differences(3, others);
  for (Eigen::Index i = 0; i < others; ++i)
    differences.col(i) = boundary.points[static_cast<std::size_t>(i) + 1] - first;
  const Eigen::MatrixXd gram = differences.transpose() * differences;
  const Eigen::VectorXd a = (2.0 * gram).completeOrthogonalDecomposition().solve(gram.diagonal());
  const Vector3 radius = differences * a;
  return {first + radius, radius.squaredNorm()};
}

/** Smallest ball of points [0, count) that has the boundary's on its surface. Not deeper than four calls. */
Ball enclose(const std::vector<Vector3>& points, std::size_t count, const Boundary& boundary) {
  Ball ball = throughAll(boundary);
  if (boundary.count == boundary.points.size()) return ball;
  for (std::size_t i = 0; i < count; ++i) {
    if (!ball.holds(points[i])) ball = enclose(points, i, boundary.with(points[i]));
  }
  return ball;
}

std::vector<Vector3> shuffled(const std::vector<Vec3>& points) {
  std::vector<Vector3> order;
  for (const Vec3& point : points) {
    if (std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2])) order.push_back(toEigen(point));
  }
  Random random(kSeed);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random.next() % i]);
  return order;
}

}  // namespace

Sphere enclosingSphere(std::vector<Vec3> points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());  // a hand that rests
  const std::vector<Vector3> order = shuffled(points);
  const Ball ball = enclose(order, order.size(), {});
  return {toArray(ball.centre), std::sqrt(std::max(0.0, ball.squared_radius))};
}

}  // namespace raven2_trainer::training
