#include "raven2_trainer/kinematics/arm_kinematics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace raven2_trainer::kinematics {
namespace {

constexpr double kDegree = kPi / 180.0;
constexpr double kLink12 = 75.0 * kDegree;  // La12, raven2 include/raven/r2_kinematics.h
constexpr double kLink23 = 52.0 * kDegree;  // La23

/** Constants of the chain that differ between the arms (raven2.md 2.1, 2.2). */
struct Chain {
  std::array<double, 6> alpha;  // [rad] twist before each joint
  double theta3;                // [rad] fixed rotation of the insertion frame
  double offset1, offset2;      // [rad] joint to DH angle
  double sign;                  // +1 gold, -1 green: sign of z in the inverse
};

const Chain& chain(Arm arm) noexcept {
  static const std::array<Chain, kArmCount> chains{
      Chain{{0.0, kLink12, kPi - kLink23, 0.0, kPi / 2, kPi / 2}, kPi / 2, 205.0 * kDegree, kPi, 1.0},
      Chain{{kPi, kLink12, kLink23, 0.0, kPi / 2, kPi / 2}, -kPi / 2, 25.0 * kDegree, 0.0, -1.0}};
  return chains[index(arm)];
}
constexpr double kOffset5 = -kPi / 2;

/** RotX(alpha) TransX(a) RotZ(theta) TransZ(d). */
Pose link(double alpha, double a, double theta, double d) noexcept {
  const double ca = std::cos(alpha), sa = std::sin(alpha), ct = std::cos(theta), st = std::sin(theta);
  Pose pose;
  pose.R << ct, -st, 0.0, ca * st, ca * ct, -sa, sa * st, sa * ct, ca;
  pose.p << a, -sa * d, ca * d;
  return pose;
}

using Frames = std::array<Pose, 7>;  // X_B0 .. X_B6, X_B0 = identity

Frames frames(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept {
  const Chain& c = chain(arm);
  Frames X;
  X[1] = X[0] * link(c.alpha[0], 0.0, q[kShoulder] + c.offset1, 0.0);
  X[2] = X[1] * link(c.alpha[1], 0.0, q[kElbow] + c.offset2, 0.0);
  X[3] = X[2] * link(c.alpha[2], 0.0, c.theta3, q[kInsertion]);
  X[4] = X[3] * link(c.alpha[3], 0.0, q[kToolRotation], geometry.d4);
  X[5] = X[4] * link(c.alpha[4], 0.0, q[kWrist] + kOffset5, 0.0);
  X[6] = X[5] * link(c.alpha[5], geometry.lw, jawMidline(q), 0.0);
  return X;
}

double wrap(double angle) noexcept {
  return std::remainder(angle, 2.0 * kPi);
}

constexpr double kSingular = 1e-5;  // rounding of the robot's inverse
constexpr double kMaxError = kPi;   // squared error above which the robot refuses a solution
constexpr double kInsertionWeight = 100.0;
constexpr double kUnwrapAbove = 300.0 * kDegree;

/** theta 1 and 2 and the wrist, once P5 and d3 are chosen (steps 3 to 5 of raven2.md 2.5). */
class Solver {
 public:
  Solver(const ArmGeometry& geometry, Arm arm, const Pose& X_BT, double opening, const JointArray& current) noexcept
      : geometry_(geometry), chain_(chain(arm)), X_BT_(X_BT), opening_(opening), current_(current) {}

  IkResult solve() noexcept {
    const Vector3 rcm_T = X_BT_.inverse().p;
    const Eigen::Vector2d direction(rcm_T.x(), rcm_T.y());
    if (direction.norm() < 1e-12) return {IkStatus::kSingularRcm, {}};
    for (const double side : {1.0, -1.0})
      tryWristPoint(side * geometry_.lw * direction.normalized());
    if (error_ <= kMaxError) return {IkStatus::kOk, best_};
    if (singular_) return {IkStatus::kSingularRcm, {}};
    return {found_ ? IkStatus::kTooFar : IkStatus::kOutOfReach, {}};
  }

 private:
  void tryWristPoint(const Eigen::Vector2d& p5_T) noexcept {
    const Vector3 p5 = X_BT_ * Vector3(p5_T.x(), p5_T.y(), 0.0);
    const double reach = p5.norm();
    if (reach <= geometry_.lw) {
      singular_ = true;
      return;
    }
    for (const double d : {-reach, reach})
      tryInsertion(p5, d);
  }

  void tryInsertion(const Vector3& p5, double d) noexcept {
    const double s12 = std::sin(kLink12), c12 = std::cos(kLink12), s23 = std::sin(kLink23), c23 = std::cos(kLink23);
    double cos2 = -chain_.sign * (p5.z() / d + c12 * c23) / (s12 * s23);
    if (std::abs(cos2) > 1.0 + kSingular) return;
    cos2 = std::clamp(cos2, -1.0, 1.0);
    for (const double theta2 : {std::acos(cos2), -std::acos(cos2)}) {
      const double b1 = std::sin(theta2) * s23;
      const double b2 = std::cos(theta2) * c12 * s23 - chain_.sign * s12 * c23;
      Eigen::Matrix2d B;
      B << b1, chain_.sign * b2, -chain_.sign * b2, b1;
      if (chain_.sign < 0.0) B << b1, b2, b2, -b1;
      const Eigen::Vector2d cs = B.inverse() * Eigen::Vector2d(p5.x(), p5.y()) / d;
      tryWrist(std::atan2(cs.y(), cs.x()), theta2, d - geometry_.d4);
    }
  }

  void tryWrist(double theta1, double theta2, double d3) noexcept {
    const Pose X_B3 = link(chain_.alpha[0], 0, theta1, 0) * link(chain_.alpha[1], 0, theta2, 0) *
                      link(chain_.alpha[2], 0, chain_.theta3, d3);
    const Pose X_36 = X_B3.inverse() * X_BT_;
    const double c5 = -X_36.R(2, 2);
    const double s5 = (X_36.p.z() - geometry_.d4) / geometry_.lw;
    const bool straight_up = std::abs(c5) <= kSingular;
    const double c4 = straight_up ? X_36.R(0, 2) / s5 : X_36.p.x() / (geometry_.lw * c5);
    const double s4 = straight_up ? X_36.R(1, 2) / s5 : X_36.p.y() / (geometry_.lw * c5);
    const double theta4 = std::atan2(s4, c4);
    const double theta5 = std::atan2(s5, c5);
    const Pose X_35 = link(chain_.alpha[3], 0, theta4, geometry_.d4) * link(chain_.alpha[4], 0, theta5, 0);
    const Matrix3 R_56 = X_35.R.transpose() * X_36.R;  // RotX(90) RotZ(theta6)
    offer(theta1, theta2, d3, theta4, theta5, std::atan2(-R_56(0, 1), R_56(0, 0)));
  }

  void offer(double theta1, double theta2, double d3, double theta4, double theta5, double midline) noexcept {
    JointArray q{};
    q[kShoulder] = wrap(theta1 - chain_.offset1);
    q[kElbow] = wrap(theta2 - chain_.offset2);
    q[kInsertion] = d3;
    q[kToolRotation] = unwrapRoll(theta4);
    q[kWrist] = wrap(theta5 - kOffset5);
    q[kGrasp1] = -midline + opening_ / 2;
    q[kGrasp2] = midline + opening_ / 2;
    const double error = distance(q);
    if (!std::isfinite(error)) return;
    found_ = true;
    if (error >= error_) return;
    error_ = error;
    best_ = q;
  }

  double unwrapRoll(double roll) const noexcept {
    if (roll - current_[kToolRotation] > kUnwrapAbove) return roll - 2.0 * kPi;
    if (current_[kToolRotation] - roll > kUnwrapAbove) return roll + 2.0 * kPi;
    return roll;
  }

  double distance(const JointArray& q) const noexcept {
    double sum = 0.0;
    for (std::size_t j = 0; j <= kWrist; ++j) {
      const double e = (q[j] - current_[j]) * (j == kInsertion ? kInsertionWeight : 1.0);
      sum += e * e;
    }
    const double midline = jawMidline(q) - jawMidline(current_);
    return sum + midline * midline;
  }

  const ArmGeometry& geometry_;
  const Chain& chain_;
  const Pose& X_BT_;
  double opening_;
  const JointArray& current_;
  double error_{std::numeric_limits<double>::infinity()};
  JointArray best_{};
  bool found_{false};
  bool singular_{false};
};

}  // namespace

double jawMidline(const JointArray& q) noexcept {
  return (q[kGrasp2] - q[kGrasp1]) / 2;
}

double jawOpening(const JointArray& q) noexcept {
  return q[kGrasp1] + q[kGrasp2];
}

Pose forward(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept {
  return frames(geometry, arm, q)[6];
}

Jacobian jacobian(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept {
  const Frames X = frames(geometry, arm, q);
  Jacobian J = Jacobian::Zero();
  constexpr std::array<std::size_t, 5> kFrameOfJoint{1, 2, 3, 4, 5};
  for (std::size_t j = 0; j <= kWrist; ++j) {
    const Pose& joint = X[kFrameOfJoint[j]];
    const Vector3 axis = joint.R.col(2);
    const auto column = static_cast<Eigen::Index>(j);
    if (j == kInsertion) {
      J.block<3, 1>(0, column) = axis;
    } else {
      J.block<3, 1>(0, column) = axis.cross(X[6].p - joint.p);
      J.block<3, 1>(3, column) = axis;
    }
  }
  // The tip lies on the jaw axis, so the mid-line only turns it.
  J.block<3, 1>(3, kGrasp1) = -0.5 * X[6].R.col(2);
  J.block<3, 1>(3, kGrasp2) = 0.5 * X[6].R.col(2);
  return J;
}

IkResult inverse(const ArmGeometry& geometry,
                 Arm arm,
                 const Pose& X_BT,
                 double opening,
                 const JointArray& current) noexcept {
  return Solver(geometry, arm, X_BT, opening, current).solve();
}

bool applyJointLimits(const ArmGeometry& geometry, JointArray* q) noexcept {
  const JointArray before = *q;
  for (std::size_t j = 0; j <= kWrist; ++j) {
    (*q)[j] = std::clamp((*q)[j], geometry.q_min[j], geometry.q_max[j]);
  }
  (*q)[kGrasp1] = std::max((*q)[kGrasp1], geometry.q_min[kGrasp1]);
  return before != *q;
}

}  // namespace raven2_trainer::kinematics
