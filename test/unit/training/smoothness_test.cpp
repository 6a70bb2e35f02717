#include "raven2_trainer/training/smoothness.h"

#include <cmath>
#include <functional>
#include <limits>

#include "gtest/gtest.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::training {
namespace {

constexpr double kRate = 100.0;  // [Hz]
constexpr double kExact = 1e-7;  // relative: the references have seven places

// Numbers without a formula are from numpy, by the published definitions
// (test/python/test_smoothness_references.py derives every one of them). Those of the first test are also published
// (github.com/siva82kb/SPARC).

struct Reference {
  double sparc, dlj, ldlj;
};

void expectSmoothness(const std::vector<double>& speed, const Reference& reference) {
  EXPECT_NEAR(spectralArcLength(speed, kRate).value(), reference.sparc, kExact * std::abs(reference.sparc));
  EXPECT_NEAR(dimensionlessJerk(speed, kRate).value(), reference.dlj, kExact * std::abs(reference.dlj));
  EXPECT_NEAR(logDimensionlessJerk(speed, kRate).value(), reference.ldlj, kExact * std::abs(reference.ldlj));
}

std::vector<double> sample(std::size_t count, const std::function<double(double)>& speed, double start = 0.0) {
  std::vector<double> samples;
  for (std::size_t k = 0; k < count; ++k)
    samples.push_back(speed(start + static_cast<double>(k) / kRate));
  return samples;
}

/** Speed of one minimum-jerk stroke of length 1 (Flash and Hogan 1985). */
std::vector<double> stroke(double duration) {
  return sample(static_cast<std::size_t>(duration * kRate), [&](double t) {
    const double s = t / duration;
    return (30.0 * s * s - 60.0 * s * s * s + 30.0 * s * s * s * s) / duration;
  });
}

void append(std::vector<double>* samples, const std::vector<double>& more) {
  samples->insert(samples->end(), more.begin(), more.end());
}

TEST(Smoothness, OfABellIsThePublishedOne) {
  expectSmoothness(sample(
                       200, [](double t) { return std::exp(-5.0 * t * t); }, -1.0),
                   {-1.4140313, -335.7468370, -5.816357415});
}

TEST(Smoothness, OfOneStrokeHardlyDependsOnItsDuration) {
  expectSmoothness(stroke(1.0), {-1.4058293, -185.7012255, -5.224139068});
  expectSmoothness(stroke(2.0), {-1.4058293, -194.9117988, -5.272547142});
}

TEST(Smoothness, OfOneStrokeGoesToItsClosedForm) {
  // 720 D^2 / T^5 is the integral of a minimum-jerk stroke's squared jerk, its peak speed 30/16 D/T.
  const double limit = -720.0 / std::pow(30.0 / 16.0, 2);
  EXPECT_NEAR(dimensionlessJerk(stroke(200.0), kRate).value(), limit, 1e-3 * std::abs(limit));
  EXPECT_NEAR(limit, -204.8, 1e-12);
}

TEST(Smoothness, OfSeveralStrokesIsLess) {
  std::vector<double> two = stroke(1.0);
  two.resize(150, 0.0);
  append(&two, stroke(1.0));
  expectSmoothness(two, {-3.1190251, -6021.5976152, -8.703107888});
  const std::vector<double> four = sample(400, [](double t) { return std::abs(std::sin(kPi * t)); });
  EXPECT_NEAR(spectralArcLength(four, kRate).value(), -3.0333230, 1e-6);
}

TEST(Smoothness, DoesNotDependOnTheUnitOfLength) {
  std::vector<double> millimetres = stroke(1.0);
  for (double& speed : millimetres)
    speed *= 60.0;
  EXPECT_NEAR(spectralArcLength(millimetres, kRate).value(), spectralArcLength(stroke(1.0), kRate).value(), 1e-12);
  EXPECT_NEAR(dimensionlessJerk(millimetres, kRate).value(), dimensionlessJerk(stroke(1.0), kRate).value(), 1e-9);
}

TEST(Smoothness, OfConstantSpeedHasNoLogarithm) {
  const std::vector<double> constant(200, 0.037);
  EXPECT_NEAR(spectralArcLength(constant, kRate).value(), -2.4011978, 1e-6);
  EXPECT_NEAR(dimensionlessJerk(constant, kRate).value(), 0.0, 1e-9);
  EXPECT_FALSE(logDimensionlessJerk(constant, kRate));
}

TEST(Smoothness, OfNothingIsNothing) {
  for (const std::vector<double>& none :
       {std::vector<double>{}, std::vector<double>{1.0, 2.0, 1.0}, std::vector<double>(100, 0.0)}) {
    EXPECT_FALSE(spectralArcLength(none, kRate));
    EXPECT_FALSE(dimensionlessJerk(none, kRate));
    EXPECT_FALSE(logDimensionlessJerk(none, kRate));
  }
  EXPECT_TRUE(spectralArcLength({0.0, 1.0, 2.0, 0.0}, kRate));
  EXPECT_TRUE(logDimensionlessJerk({0.0, 1.0, 2.0, 0.0}, kRate));
}

TEST(Smoothness, OfValuesThatAreNotFiniteIsNothing) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<double> speed = stroke(1.0);
    speed[40] = bad;
    EXPECT_FALSE(spectralArcLength(speed, kRate));
    EXPECT_FALSE(dimensionlessJerk(speed, kRate));
    EXPECT_FALSE(logDimensionlessJerk(speed, kRate));
    EXPECT_FALSE(meanJerk({Vec3{}, Vec3{}, Vec3{0.0, bad, 0.0}, Vec3{}, Vec3{}}, kRate));
  }
}

TEST(MeanJerk, OfAMinimumJerkStrokeIsTheClosedForm) {
  constexpr double kLength = 0.06, kDuration = 1.5;  // [m], [s]
  std::vector<Vec3> places;
  for (int k = 0; k <= 1500; ++k) {
    const double s = k / 1500.0;
    const double part = 10.0 * std::pow(s, 3) - 15.0 * std::pow(s, 4) + 6.0 * std::pow(s, 5);
    places.push_back({0.6 * kLength * part, 0.1, -0.8 * kLength * part});
  }
  const double closed = std::sqrt(720.0) * kLength / std::pow(kDuration, 3);  // 0.4770 m/s^3
  // The first and the last of the differences are one sample inside the ends, where the jerk is greatest: with
  // j(s) = 60 - 360 s + 360 s^2, 0.26 % at 1500 samples.
  EXPECT_NEAR(meanJerk(places, 1000.0).value(), closed, 0.005 * closed);
}

TEST(MeanJerk, OfACubicIsItsThirdDerivative) {
  std::vector<Vec3> places;
  for (int k = 0; k < 50; ++k)
    places.push_back({0.5 * std::pow(k / kRate, 3), 2.0 * k / kRate, -1.0});
  EXPECT_NEAR(meanJerk(places, kRate).value(), 3.0, 1e-6);
  EXPECT_FALSE(meanJerk({Vec3{}, Vec3{}, Vec3{}}, kRate));
  EXPECT_EQ(meanJerk({Vec3{}, Vec3{}, Vec3{}, Vec3{}}, kRate).value(), 0.0);
}

}  // namespace
}  // namespace raven2_trainer::training
