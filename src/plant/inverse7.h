#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace raven2_trainer::plant {

/**
 * Inverse of a symmetric positive definite 7x7 matrix, of which only the lower triangle is read: factors of Cholesky,
 * and two triangular solutions for all columns of the identity at once. The sums have the order of Eigen 3.4's
 * `llt().solve(Identity)`, so the bits are the same. That takes five times as long, because Eigen packs blocks as for
 * large matrices. Real-time safe.
 */
class Inverse7 {
 public:
  using Matrix = Eigen::Matrix<double, 7, 7>;

  explicit Inverse7(const Matrix& matrix) noexcept {
    factorise(matrix);
    solveLower();
    solveUpper();
  }

  Matrix matrix() const noexcept {
    Matrix result;
    for (int i = 0; i < kSize; ++i)
      result.row(i) = X_[index(i)].head<kSize>();
    return result;
  }

 private:
  static constexpr int kSize = 7;
  static constexpr int kPanel = 4;  // rows that Eigen's triangular solver takes before it updates all others
  using Row = Eigen::Array<double, kSize + 1, 1>;  // one more than needed: whole packets

  static constexpr std::size_t index(int i) noexcept { return static_cast<std::size_t>(i); }

  /** L L^T = matrix. */
  void factorise(const Matrix& matrix) noexcept {
    for (int k = 0; k < kSize; ++k) {
      double squares = 0.0;
      for (int j = 0; j < k; ++j)
        squares += L_(k, j) * L_(k, j);
      L_(k, k) = std::sqrt(matrix(k, k) - squares);
      for (int i = k + 1; i < kSize; ++i) {
        double sum = 0.0;
        for (int j = 0; j < k; ++j)
          sum += L_(i, j) * L_(k, j);
        L_(i, k) = (matrix(i, k) - sum) / L_(k, k);
      }
    }
  }

  /** X = L^-1. */
  void solveLower() noexcept {
    for (int i = 0; i < kSize; ++i) {
      X_[index(i)].setZero();
      X_[index(i)][i] = 1.0;
    }
    for (int begin = 0; begin < kSize; begin += kPanel) {
      const int end = std::min(begin + kPanel, kSize);
      for (int k = begin; k < end; ++k) {
        X_[index(k)] *= 1.0 / L_(k, k);
        for (int i = k + 1; i < end; ++i)
          X_[index(i)] -= X_[index(k)] * L_(i, k);
      }
      for (int i = end; i < kSize; ++i) {
        Row sum = Row::Zero();
        for (int k = begin; k < end; ++k)
          sum += X_[index(k)] * L_(i, k);
        X_[index(i)] -= sum;
      }
    }
  }

  /** X = L^-T X, from the last row up. */
  void solveUpper() noexcept {
    for (int end = kSize; end > 0; end -= kPanel) {
      const int begin = std::max(end - kPanel, 0);
      for (int i = end - 1; i >= begin; --i) {
        subtractBelow(i, i + 1, end);
        X_[index(i)] *= 1.0 / L_(i, i);
      }
      for (int i = 0; i < begin; ++i)
        subtractBelow(i, begin, end);
    }
  }

  /** Takes from row i of X the terms that rows `begin` to `end` have in row i of L^T X. */
  void subtractBelow(int i, int begin, int end) noexcept {
    Row sum = Row::Zero();
    for (int k = begin; k < end; ++k)
      sum += X_[index(k)] * L_(k, i);
    X_[index(i)] -= sum;
  }

  Matrix L_;
  std::array<Row, kSize> X_;
};

}  // namespace raven2_trainer::plant
