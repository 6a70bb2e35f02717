#include "raven2_trainer/detector/identify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::detector {
namespace {

constexpr double kCount = 2.0 * kPi / 4000.0;  // [rad]

/** An axis with everything, integrated in 100 parts of a cycle, seen through the encoder: not the detector's own
 *  equations of motion, but a finer solution of the same law. */
std::vector<AxisSample> swing(const DetectorAxis& truth, std::uint64_t seed, int cycles) {
  constexpr int kParts = 100;
  const double dt = kTickSeconds / kParts;
  Random random(seed);
  std::vector<AxisSample> stretch;
  double position = 0.0, velocity = 0.0, phase = random.uniform(0, 6);
  for (int k = 0; k < cycles; ++k) {
    AxisSample sample;
    sample.q = {0.5 + 0.3 * std::sin(0.001 * k + phase),
                1.5 + 0.2 * std::cos(0.0013 * k),
                0.4 + 0.02 * std::sin(0.0007 * k),
                0,
                0,
                0,
                0};
    sample.motor = std::floor(position / kCount) * kCount;
    const double load =
        truth.offset + truth.gravity[0] * sample.q[0] + truth.gravity[1] * sample.q[1] + truth.gravity[2] * sample.q[2];
    const double torque = load + 0.25 * std::sin(0.012 * k + phase) + 0.1 * std::sin(0.045 * k);
    sample.torque = torque;
    for (int part = 0; part < kParts; ++part) {
      const double friction = truth.viscous * velocity + truth.coulomb * std::tanh(velocity / 0.05);
      velocity += dt * (torque - load - friction) / truth.inertia;
      position += dt * velocity;
    }
    stretch.push_back(sample);
  }
  return stretch;
}

DetectorAxis someAxis() {
  DetectorAxis axis;
  axis.inertia = 3.8e-4;
  axis.viscous = 1.8e-3;
  axis.coulomb = 0.06;
  axis.offset = -0.04;
  axis.gravity = {0.12, -0.08, 0.3};
  return axis;
}

TEST(AxisFit, FindsTheAxisBehindTheEncoder) {
  const DetectorAxis truth = someAxis();
  AxisFit fit;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    fit.add(swing(truth, seed, 8000));
  const DetectorAxis found = fit.solve();
  // to 3 %: the encoder's counts and friction's turn within the 16 ms of a sample are not the axis'
  EXPECT_NEAR(found.inertia, truth.inertia, 0.03 * truth.inertia);
  EXPECT_NEAR(found.viscous, truth.viscous, 0.03 * truth.viscous);
  EXPECT_NEAR(found.coulomb, truth.coulomb, 0.03 * truth.coulomb);
  const auto load = [](const DetectorAxis& axis, double a, double b, double c) {
    return axis.offset + axis.gravity[0] * a + axis.gravity[1] * b + axis.gravity[2] * c;
  };
  EXPECT_NEAR(load(found, 0.3, 1.4, 0.39), load(truth, 0.3, 1.4, 0.39), 0.002);
  EXPECT_NEAR(load(found, 0.7, 1.6, 0.41), load(truth, 0.7, 1.6, 0.41), 0.002);
  EXPECT_GT(fit.explained(found), 0.98);
  DetectorAxis wrong = found;
  wrong.coulomb = 0.0;
  EXPECT_LT(fit.explained(wrong), fit.explained(found) - 0.02);
}

TEST(AxisFit, RefusesWhatHardlyMoves) {
  AxisFit fit;
  fit.add(std::vector<AxisSample>(5000));
  EXPECT_EQ(fit.samples(), 0U);
  EXPECT_THROW(fit.solve(), Exception);
}

TEST(AxisFit, RefusesAnAxisThatRunsAgainstItsTorque) {
  std::vector<AxisSample> reversed = swing(someAxis(), 1, 8000);
  for (AxisSample& sample : reversed)
    sample.torque = -sample.torque;
  AxisFit fit;
  fit.add(reversed);
  EXPECT_THROW(fit.solve(), Exception);
}

TEST(TailPercentile, IsThatOfAllValues) {
  for (const double percentile : {50.0, 90.0, 99.0, 99.9}) {
    Random random(7);
    std::vector<double> values;
    TailPercentile tail(percentile, 20000);
    for (int i = 0; i < 20000; ++i) {
      values.push_back(random.normal());
      tail.add(values.back());
    }
    std::sort(values.begin(), values.end());
    const auto above = static_cast<std::size_t>(std::floor((1.0 - percentile / 100.0) * 20000));
    EXPECT_EQ(tail.value(), values[values.size() - 1 - above]) << percentile;
  }
}

TEST(TailPercentile, OfFewerValuesThanAnnounced) {
  TailPercentile tail(99.0, 1000);
  EXPECT_EQ(tail.value(), 0.0);
  for (int i = 1; i <= 100; ++i)
    tail.add(i);
  EXPECT_EQ(tail.value(), 99.0) << "one of a hundred may exceed it";
}

}  // namespace
}  // namespace raven2_trainer::detector
