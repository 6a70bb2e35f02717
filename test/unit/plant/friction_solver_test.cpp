#include "plant/friction_solver.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::plant {
namespace {

using Vector = FrictionSolver::Vector;
using Matrix = FrictionSolver::Matrix;

const FrictionSolver::Stops kNoStops{};
constexpr Eigen::Index kAll = FrictionSolver::kRates;

/** Coupled, well-conditioned inverse inertia. */
Matrix coupled() {
  Random random(5);
  Matrix B;
  for (Eigen::Index i = 0; i < B.size(); ++i)
    B(i) = random.uniform(-0.3, 0.3);
  return Matrix::Identity() + B * B.transpose();
}

TEST(FrictionSolver, HoldsExactlyStillWithinItsLimit) {
  FrictionSolver solver;
  Vector free = Vector::Constant(0.01);
  const Vector velocity = solver.solve(coupled(), free, Vector::Constant(1.0), kNoStops, 0);
  EXPECT_EQ(velocity, Vector::Zero());
}

TEST(FrictionSolver, SlidingAxisIsSlowedByTheFullFriction) {
  FrictionSolver solver;
  Vector free = Vector::Zero();
  free[2] = 5.0;
  Vector limit = Vector::Zero();
  limit[2] = 0.3;
  const Vector velocity = solver.solve(2.0 * Matrix::Identity(), free, limit, kNoStops, 0);
  EXPECT_NEAR(velocity[2], 5.0 - 2.0 * 0.3, 1e-12);
}

TEST(FrictionSolver, NeverAddsEnergyAndOpposesEverySlidingAxis) {
  const Matrix W = coupled();
  Random random(9);
  FrictionSolver solver;
  for (int n = 0; n < 200; ++n) {
    Vector free, limit;
    for (Eigen::Index j = 0; j < kAll; ++j) {
      free[j] = random.uniform(-1, 1);
      limit[j] = random.uniform(0, 0.5);
    }
    const Vector velocity = solver.solve(W, free, limit, kNoStops, 0);
    const Vector impulse = W.inverse() * (velocity - free);
    EXPECT_LE(velocity.dot(W.inverse() * velocity), free.dot(W.inverse() * free) + 1e-9);
    for (Eigen::Index j = 0; j < kAll; ++j) {
      EXPECT_LE(std::abs(impulse[j]), limit[j] + 1e-6);
      if (velocity[j] == 0.0) continue;
      EXPECT_NEAR(impulse[j], velocity[j] > 0 ? -limit[j] : limit[j], 1e-6);
    }
  }
}

TEST(FrictionSolver, StopLetsNothingThroughAndPullsNothingBack) {
  FrictionSolver::Stops stops{};
  stops[0] = {0, 1.0, -0.1};
  FrictionSolver solver;
  Vector free = Vector::Zero();
  free[0] = -3.0;
  EXPECT_NEAR(solver.solve(coupled(), free, Vector::Zero(), stops, 1)[0], -0.1, 1e-7);
  free[0] = 3.0;
  EXPECT_NEAR(solver.solve(coupled(), free, Vector::Zero(), stops, 1)[0], 3.0, 1e-12);
}

TEST(FrictionSolver, StopsHoldOnEitherSideOfEachRate) {
  for (const Eigen::Index coordinate : {Eigen::Index{0}, Eigen::Index{9}}) {
    for (const double sign : {-1.0, 1.0}) {
      FrictionSolver::Stops stops{};
      stops[0] = {coordinate, sign, -0.1};
      FrictionSolver solver;
      Vector free = Vector::Zero();
      free[coordinate] = -3.0 * sign;
      EXPECT_NEAR(solver.solve(coupled(), free, Vector::Zero(), stops, 1)[coordinate], -0.1 * sign, 1e-7);
      free[coordinate] = 3.0 * sign;
      EXPECT_NEAR(solver.solve(coupled(), free, Vector::Zero(), stops, 1)[coordinate], 3.0 * sign, 1e-12);
    }
  }
}

TEST(FrictionSolver, WhatStuckBeforeIsForgotten) {
  const Matrix W = coupled();
  Vector push = Vector::Zero();
  push[2] = 0.5;
  const Vector limit = Vector::Constant(0.4);
  FrictionSolver used, fresh;
  used.solve(W, push, limit, kNoStops, 0);
  used.reset();
  EXPECT_EQ(used.solve(W, -push, limit, kNoStops, 0), fresh.solve(W, -push, limit, kNoStops, 0));
  EXPECT_EQ(used.iterations(), fresh.iterations());
}

}  // namespace
}  // namespace raven2_trainer::plant
