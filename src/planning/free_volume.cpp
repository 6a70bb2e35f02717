#include "planning/free_volume.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

constexpr int kBisections = 60;        // of an interval no wider than 1: past the last bit of a double near 1
constexpr double kNegligible = 1e-18;  // of a sum

/** Natural logarithm of n over k. */
double logBinomial(std::uint32_t n, std::uint32_t k) {
  double sum = 0.0;
  for (std::uint32_t i = 1; i <= k; ++i)
    sum += std::log(static_cast<double>(n - k + i) / i);
  return sum;
}

/** Probability of at most k hits in n draws of probability p >= k / n: the terms fall from the k-th down. */
double atMost(std::uint32_t k, std::uint32_t n, double p, double log_binomial) {
  const double odds = (1.0 - p) / p;
  double term = std::exp(log_binomial + k * std::log(p) + (n - k) * std::log1p(-p));
  double sum = term;
  for (std::uint32_t i = k; i > 0 && term > kNegligible * sum; --i) {
    term *= odds * i / (n - i + 1.0);
    sum += term;
  }
  return sum;
}

}  // namespace

double upperBound(std::uint32_t hits, std::uint32_t samples, double confidence) {
  if (hits >= samples) return 1.0;
  const double log_binomial = logBinomial(samples, hits);
  double low = static_cast<double>(hits) / samples, high = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double p = (low + high) / 2;
    (p < 1.0 && p > 0.0 && atMost(hits, samples, p, log_binomial) > 1.0 - confidence ? low : high) = p;
  }
  return high;
}

FreeVolume estimateFreeVolume(const std::function<bool(const UnitState&)>& is_free,
                              std::uint32_t samples,
                              std::uint64_t seed,
                              double confidence) {
  if (samples < 1) throw std::invalid_argument("estimateFreeVolume: samples is 0; it must be at least 1");
  if (!(confidence > 0.0 && confidence < 1.0))
    throw std::invalid_argument("estimateFreeVolume: confidence is " + std::to_string(confidence) +
                                "; it must be in (0, 1)");
  Random random(seed);
  std::uint32_t free = 0;
  for (std::uint32_t i = 0; i < samples; ++i) {
    UnitState unit;
    for (double& x : unit)
      x = random.uniform(0.0, 1.0);
    free += is_free(unit) ? 1 : 0;
  }
  return {static_cast<double>(free) / samples, upperBound(free, samples, confidence)};
}

double unitBallVolume(int dimension) {
  return std::pow(kPi, dimension / 2.0) / std::tgamma(dimension / 2.0 + 1.0);
}

double fmtGamma(double free_volume, double multiplier) {
  constexpr int d = static_cast<int>(kPlanDimension);
  return multiplier * 2.0 * std::pow(free_volume / (d * unitBallVolume(d)), 1.0 / d);
}

double fmtRadius(double free_volume, double multiplier, std::uint32_t samples) {
  const double n = samples;
  return fmtGamma(free_volume, multiplier) * std::pow(std::log(n) / n, 1.0 / static_cast<double>(kPlanDimension));
}

}  // namespace raven2_trainer::planning
