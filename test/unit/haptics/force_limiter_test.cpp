#include "raven2_trainer/haptics/force_limiter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

constexpr HapticGains kGains{150.0, 1.0, 0.003, 0.05, /*max_force=*/3.0, /*max_slew=*/100.0};
constexpr double kTick = 0.001;

TEST(ForceLimiter, RisesAndFallsAtItsSlewAlongAStraightLine) {
  ForceLimiter limiter(kGains);
  for (int i = 1; i <= 20; ++i)
    EXPECT_NEAR((limiter.step({0.0, 2.0, 0.0}, kTick) - Vector3d(0.0, 0.1 * i, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(limiter.step({0.0, 2.0, 0.0}, kTick), Vector3d(0.0, 2.0, 0.0));
  const double side = 0.1 / std::sqrt(2.0);  // from (0, 2, 0) towards (2, 0, 0)
  EXPECT_NEAR((limiter.step({2.0, 0.0, 0.0}, kTick) - Vector3d(side, 2.0 - side, 0.0)).norm(), 0.0, 1e-12);
}

TEST(ForceLimiter, FromSaturationToNothingTakesNoMoreThanFiftyMilliseconds) {
  ForceLimiter limiter(kGains);
  for (int i = 0; i < 100; ++i)
    limiter.step({100.0, 0.0, 0.0}, kTick);
  ASSERT_DOUBLE_EQ(limiter.step({100.0, 0.0, 0.0}, kTick).norm(), 3.0);
  int ticks = 1;
  while (limiter.step(Vector3d::Zero(), kTick) != Vector3d::Zero() && ticks < 1000)
    ++ticks;
  EXPECT_EQ(ticks, 30);
}

TEST(ForceLimiter, AGapGivesNoMoreThanATickAndNoTimeGivesNothing) {
  ForceLimiter limiter(kGains);
  EXPECT_NEAR(limiter.step({3.0, 0.0, 0.0}, 5.0).norm(), 0.1, 1e-12);
  EXPECT_NEAR(limiter.step({3.0, 0.0, 0.0}, 0.0).norm(), 0.1, 1e-12);
  EXPECT_NEAR(limiter.step({3.0, 0.0, 0.0}, -1.0).norm(), 0.1, 1e-12);
  EXPECT_NEAR(limiter.step({3.0, 0.0, 0.0}, std::nan("")).norm(), 0.1, 1e-12);
}

TEST(ForceLimiter, WhatIsNotFiniteCountsAsNothing) {
  const double inf = std::numeric_limits<double>::infinity();
  ForceLimiter limiter(kGains);
  limiter.step({0.1, 0.0, 0.0}, kTick);
  for (const double bad : {inf, -inf, std::nan(""), 1e300}) {
    EXPECT_EQ(limiter.step({0.0, bad, 0.0}, kTick), Vector3d::Zero());
  }
}

}  // namespace
}  // namespace raven2_trainer::haptics
