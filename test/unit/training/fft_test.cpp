#include "raven2_trainer/training/fft.h"

#include <cmath>
#include <stdexcept>

#include "gtest/gtest.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::training {
namespace {

/** The definition, term by term. */
double magnitudeBySum(const std::vector<double>& x, std::size_t k, std::size_t length) {
  double re = 0.0, im = 0.0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double angle = 2.0 * kPi * static_cast<double>(k * n % length) / static_cast<double>(length);
    re += x[n] * std::cos(angle);
    im -= x[n] * std::sin(angle);
  }
  return std::hypot(re, im);
}

TEST(PowerOfTwo, IsTheSmallestThatHoldsAll) {
  EXPECT_EQ(powerOfTwo(0), 1u);
  EXPECT_EQ(powerOfTwo(1), 1u);
  EXPECT_EQ(powerOfTwo(2), 2u);
  EXPECT_EQ(powerOfTwo(3), 4u);
  EXPECT_EQ(powerOfTwo(64), 64u);
  EXPECT_EQ(powerOfTwo(65), 128u);
}

TEST(Magnitudes, AreThoseOfTheDefinitionWithZerosBehind) {
  Random random(8);
  for (const std::size_t count : {1, 2, 7, 16, 100}) {
    std::vector<double> x(count);
    for (double& value : x)
      value = random.uniform(-3.0, 3.0);
    const std::size_t length = 2 * powerOfTwo(count);
    const std::vector<double> spectrum = magnitudes(x, length);
    ASSERT_EQ(spectrum.size(), length);
    for (std::size_t k = 0; k < length; ++k)
      EXPECT_NEAR(spectrum[k], magnitudeBySum(x, k, length), 1e-11) << count << " samples, bin " << k;
  }
}

TEST(Magnitudes, OfACosineStandInItsTwoBins) {
  std::vector<double> x;
  for (int n = 0; n < 32; ++n)
    x.push_back(3.0 * std::cos(2.0 * kPi * 5.0 * n / 32.0));
  const std::vector<double> spectrum = magnitudes(x, 32);
  for (std::size_t k = 0; k < 32; ++k)
    EXPECT_NEAR(spectrum[k], k == 5 || k == 27 ? 3.0 * 16.0 : 0.0, 1e-12) << k;
}

TEST(Magnitudes, KeepTheEnergyOfALongSeries) {
  Random random(3);
  std::vector<double> x(30000);
  double energy = 0.0;
  for (double& value : x) {
    value = random.normal();
    energy += value * value;
  }
  double transformed = 0.0;
  for (const double m : magnitudes(x, 32768))
    transformed += m * m;
  EXPECT_NEAR(transformed / 32768.0, energy, 1e-9 * energy);  // Parseval
}

TEST(Magnitudes, RefuseALengthThatIsNoPowerOfTwoOrTooShort) {
  EXPECT_THROW(magnitudes({1.0, 2.0}, 3), std::invalid_argument);
  EXPECT_THROW(magnitudes({1.0, 2.0, 3.0}, 2), std::invalid_argument);
  EXPECT_THROW(magnitudes({}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace raven2_trainer::training
