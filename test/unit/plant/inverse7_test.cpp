#include "plant/inverse7.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::plant {
namespace {

/** Positive definite; entries of very different sizes, as of motors and links. */
Inverse7::Matrix positive(Random* random) {
  Inverse7::Matrix B;
  for (Eigen::Index i = 0; i < B.size(); ++i)
    B(i) = random->uniform(-1.0, 1.0) * std::exp(random->uniform(-3.0, 3.0));
  return B * B.transpose() + 0.01 * Inverse7::Matrix::Identity();
}

TEST(Inverse7, TimesTheMatrixIsTheIdentity) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Inverse7::Matrix A = positive(&random);
    const Inverse7::Matrix X = Inverse7(A).matrix();
    EXPECT_LT((A * X - Inverse7::Matrix::Identity()).norm(), 1e-12 * A.norm() * X.norm()) << i;
  }
}

TEST(Inverse7, HasTheBitsOfEigensSolution) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Inverse7::Matrix A = positive(&random);
    EXPECT_EQ(Inverse7(A).matrix(), Inverse7::Matrix(A.llt().solve(Inverse7::Matrix::Identity()))) << i;
  }
}

TEST(Inverse7, ReadsTheLowerTriangleOnly) {
  Random random(5);
  const Inverse7::Matrix A = positive(&random);
  const Inverse7::Matrix lower = A.triangularView<Eigen::Lower>();
  EXPECT_EQ(Inverse7(lower).matrix(), Inverse7(A).matrix());
}

}  // namespace
}  // namespace raven2_trainer::plant
