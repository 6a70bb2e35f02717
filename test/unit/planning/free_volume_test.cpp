#include "planning/free_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace raven2_trainer::planning {
namespace {

constexpr double kBall = kPi * kPi * kPi / 6.0 / 64.0;  // volume of the 6-ball of radius 1/2

bool inHalfCube(const UnitState& unit) {
  return unit[2] < 0.5;
}

bool inBall(const UnitState& unit) {
  double square = 0.0;
  for (const double x : unit)
    square += (x - 0.5) * (x - 0.5);
  return square < 0.25;
}

bool outsideBox(const UnitState& unit) {  // 1 - 0.8^6
  for (const double x : unit)
    if (x > 0.8) return true;
  return false;
}

TEST(FreeVolume, IsThatOfShapesKnownInClosedForm) {
  constexpr std::uint32_t n = 40000;
  const struct {
    bool (*is_free)(const UnitState&);
    double truth;
  } cases[] = {{inHalfCube, 0.5}, {inBall, kBall}, {outsideBox, 1.0 - std::pow(0.8, 6)}};
  for (const auto& c : cases) {
    const double deviation = std::sqrt(c.truth * (1 - c.truth) / n);
    const FreeVolume volume = estimateFreeVolume(c.is_free, n, 7, 0.95);
    EXPECT_NEAR(volume.mean, c.truth, 4 * deviation);
    // The bound's normal approximation, 1.645 deviations, is close enough with thousands of hits.
    EXPECT_NEAR(volume.upper - volume.mean, 1.645 * deviation, 0.1 * deviation);
  }
}

TEST(FreeVolume, TheBoundHoldsAsOftenAsItSays) {
  int held = 0;
  constexpr int kRuns = 1000;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed)
    held += estimateFreeVolume(inBall, 100, seed, 0.9).upper >= kBall ? 1 : 0;
  EXPECT_GE(held, 0.9 * kRuns - 3 * std::sqrt(0.09 * kRuns));
  EXPECT_LT(held, kRuns);  // a bound of limited confidence must fail at times
}

TEST(FreeVolume, SameSeedSameAnswer) {
  EXPECT_EQ(estimateFreeVolume(inBall, 1000, 3, 0.95).mean, estimateFreeVolume(inBall, 1000, 3, 0.95).mean);
  EXPECT_NE(estimateFreeVolume(inBall, 1000, 3, 0.95).mean, estimateFreeVolume(inBall, 1000, 4, 0.95).mean);
}

TEST(FreeVolume, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(estimateFreeVolume(inBall, 0, 1, 0.95), std::invalid_argument);
  EXPECT_THROW(estimateFreeVolume(inBall, 10, 1, 1.0), std::invalid_argument);
  EXPECT_THROW(estimateFreeVolume(inBall, 10, 1, std::nan("")), std::invalid_argument);
}

TEST(UpperBound, ClosedFormsAndTables) {
  EXPECT_NEAR(upperBound(0, 20, 0.95), 1.0 - std::pow(0.05, 1.0 / 20), 1e-12);  // (1 - p)^n = 0.05
  EXPECT_NEAR(upperBound(19, 20, 0.95), std::pow(0.95, 1.0 / 20), 1e-12);       // 1 - p^n = 0.05
  EXPECT_EQ(upperBound(20, 20, 0.95), 1.0);
  EXPECT_NEAR(upperBound(3, 10, 0.975), 0.6525, 5e-5);  // Clopper and Pearson 1934, 95 % two-sided, 3 of 10
}

TEST(UpperBound, SoFewHitsAreAsRareAsItSays) {
  // The binomial sum for 13 of 50, term by term, starting at zero hits.
  const double p = upperBound(13, 50, 0.99);
  double term = std::pow(1 - p, 50), sum = 0.0;
  for (int i = 0; i <= 13; ++i) {
    sum += term;
    term *= (50.0 - i) / (i + 1.0) * p / (1 - p);
  }
  EXPECT_NEAR(sum, 0.01, 1e-9);
}

TEST(FmtRadius, IsThatOfThePaper) {
  EXPECT_NEAR(unitBallVolume(6), kPi * kPi * kPi / 6.0, 1e-12);
  EXPECT_NEAR(unitBallVolume(2), kPi, 1e-12);
  EXPECT_NEAR(unitBallVolume(3), 4.0 / 3.0 * kPi, 1e-12);
  const double gamma = 1.1 * 2.0 * std::pow(1.0 / 6.0, 1.0 / 6.0) * std::pow(0.6 / (kPi * kPi * kPi / 6.0), 1.0 / 6.0);
  EXPECT_NEAR(fmtGamma(0.6, 1.1), gamma, 1e-12);
  EXPECT_NEAR(fmtRadius(0.6, 1.1, 500), gamma * std::pow(std::log(500.0) / 500.0, 1.0 / 6.0), 1e-12);
}

TEST(FmtRadius, GrowsWithTheFreeVolumeAndShrinksWithTheSamples) {
  EXPECT_GT(fmtRadius(0.7, 1.1, 500), fmtRadius(0.6, 1.1, 500));
  EXPECT_LT(fmtRadius(0.6, 1.1, 1000), fmtRadius(0.6, 1.1, 500));
}

}  // namespace
}  // namespace raven2_trainer::planning
