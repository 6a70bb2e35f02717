#include "raven2_trainer/raven/low_pass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven/state_estimator.h"
#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::raven {
namespace {

/** Gain at a frequency [Hz] after the transient. */
double gain(double frequency) {
  LowPass filter;
  double largest = 0.0;
  for (int k = 0; k < 4000; ++k) {
    JointArray x{};
    x.fill(std::sin(2 * kPi * frequency * k * kTickSeconds));
    const double y = filter.update(x)[kWrist];
    if (k > 2000) largest = std::max(largest, std::abs(y));
  }
  return largest;
}

TEST(LowPass, IsTheButterworthOf120Hertz) {
  // |H| of a 3rd-order Butterworth by the bilinear transform: 1 / sqrt(1 + (tan(pi f) / tan(pi fc))^6)
  for (const double f : {5.0, 60.0, 120.0, 240.0}) {
    const double ratio = std::tan(kPi * f / 1000) / std::tan(kPi * 120.0 / 1000);
    EXPECT_NEAR(gain(f), 1.0 / std::sqrt(1.0 + std::pow(ratio, 6)), 0.01) << f;
  }
}

TEST(StateEstimator, TakesOffsetsAndRestsThere) {
  for (const bool low_pass : {false, true}) {
    StateEstimator estimator(Arm::kGold, low_pass);
    std::array<std::int32_t, kChannels> counts{};
    counts.fill(1000);
    estimator.update(counts);
    JointArray motor{};
    motor.fill(2.5);
    estimator.setMotor(motor);
    for (int k = 0; k < 20; ++k) {
      estimator.update(counts);
      for (std::size_t j = 0; j < kJointCount; ++j) {
        EXPECT_NEAR(estimator.mpos()[j], 2.5, 1e-4);  // the filter's rounded coefficients have a gain of 1 - 4e-6
        EXPECT_NEAR(estimator.mvel()[j], 0.0, 0.02);
      }
    }
    counts.fill(1400);  // a tenth of a revolution
    for (int k = 0; k < 100; ++k)
      estimator.update(counts);
    EXPECT_NEAR(estimator.mpos()[kShoulder] - 2.5, encoderSign(Arm::kGold, kShoulder) * 0.2 * kPi, 1e-4);
  }
}

TEST(StateEstimator, WithoutTheFilterVelocityIsTheDifference) {
  StateEstimator estimator(Arm::kGold, false);
  std::array<std::int32_t, kChannels> counts{};
  estimator.update(counts);
  counts[0] = 1;
  estimator.update(counts);
  EXPECT_NEAR(estimator.mvel()[kShoulder], 1.571, 1e-3);  // quantum of raven2.md 3.7
}

TEST(StateEstimator, FiltersIfItIsToldToAndBeginsAtRest) {
  // raven2.md 3.7: the newest value counts 0.02864
  for (const bool low_pass : {false, true}) {
    StateEstimator estimator(Arm::kGold, low_pass);
    std::array<std::int32_t, kChannels> counts{};
    counts.fill(1000);
    const double there = encoderSign(Arm::kGold, kShoulder) * 1000 * 2 * kPi / 4000;
    for (int k = 0; k < 3; ++k) {
      estimator.update(counts);
      EXPECT_NEAR(estimator.mpos()[kShoulder], there, 1e-4) << low_pass;
      EXPECT_NEAR(estimator.mvel()[kShoulder], 0.0, 0.02) << low_pass;
    }
    counts.fill(2000);
    estimator.update(counts);
    EXPECT_NEAR(estimator.mpos()[kShoulder] / there - 1.0, low_pass ? 0.02864 : 1.0, 1e-4);
  }
}

}  // namespace
}  // namespace raven2_trainer::raven
