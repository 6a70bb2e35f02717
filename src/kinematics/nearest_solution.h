#pragma once

#include <cmath>
#include <limits>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::kinematics {

/** The solution nearest to where the arm is, by the robot's measure. */
class NearestSolution {
 public:
  explicit NearestSolution(const JointArray& current) noexcept : current_(current) {}

  void offer(const IkSolutions& solutions) noexcept {
    for (const IkSolution& solution : solutions) {
      if (solution.valid) offer(solution.q);
    }
  }
  /** Whether one is near enough for the robot. */
  bool isFound() const noexcept { return error_ <= kMaxError; }
  /** Whether no solution with this insertion [m] is near enough. */
  bool refuses(double insertion) const noexcept {
    const double error = (insertion - current_[kInsertion]) * kInsertionWeight;
    return error * error > kMaxError && std::isfinite(error * error);
  }
  const JointArray& q() const noexcept { return best_; }

 private:
  // raven2 r2_kinematics.cpp:737-799; raven2.md 2.5
  static constexpr double kMaxError = kPi;  // squared error above which the robot refuses a solution
  static constexpr double kInsertionWeight = 100.0;
  static constexpr double kUnwrapAbove = 300.0 * kPi / 180.0;

  void offer(JointArray q) noexcept {
    double& roll = q[kToolRotation];
    if (roll - current_[kToolRotation] > kUnwrapAbove) {
      roll -= 2.0 * kPi;
    } else if (current_[kToolRotation] - roll > kUnwrapAbove) {
      roll += 2.0 * kPi;
    }
    const double error = distance(q);
    if (!(error < error_)) return;
    error_ = error;
    best_ = q;
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

  const JointArray& current_;
  double error_{std::numeric_limits<double>::infinity()};
  JointArray best_{};
};

}  // namespace raven2_trainer::kinematics
