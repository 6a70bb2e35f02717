#pragma once

#include "physics/arm_recursion.h"

namespace raven2_trainer::physics {

/** A = L D L^T of a symmetric positive definite matrix, to solve A x = b: at this size plain loops that the compiler
 *  unrolls take a third of the time of Eigen's general code. Real-time safe. */
class Ldlt7 {
 public:
  explicit Ldlt7(const Matrix7& A) noexcept {
    for (Eigen::Index j = 0; j < 7; ++j) {
      double pivot = A(j, j);
      for (Eigen::Index k = 0; k < j; ++k)
        pivot -= L_(j, k) * scaled_(j, k);
      reciprocal_[j] = 1.0 / pivot;
      for (Eigen::Index i = j + 1; i < 7; ++i) {
        double rest = A(i, j);
        for (Eigen::Index k = 0; k < j; ++k)
          rest -= L_(i, k) * scaled_(j, k);
        scaled_(i, j) = rest;
        L_(i, j) = rest * reciprocal_[j];
      }
    }
  }

  Vector7 solve(Vector7 x) const noexcept {
    for (Eigen::Index j = 0; j < 7; ++j) {
      for (Eigen::Index i = j + 1; i < 7; ++i)
        x[i] -= L_(i, j) * x[j];
    }
    for (Eigen::Index j = 7; j-- > 0;) {
      x[j] *= reciprocal_[j];
      for (Eigen::Index i = j + 1; i < 7; ++i)
        x[j] -= L_(i, j) * x[i];
    }
    return x;
  }

 private:
  Matrix7 L_, scaled_;  // below the diagonal: L, and L D
  Vector7 reciprocal_;  // of D
};

}  // namespace raven2_trainer::physics
