#include "raven2_trainer/training/band.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/training/metric_names.h"

namespace raven2_trainer::training {

namespace {

constexpr double kFar = 1e9;  // stands for what no spread can measure

/** [spreads] Beyond a limit. */
double excessOf(double beyond, double spread) {
  if (spread > 0.0) return std::clamp(beyond / spread, -kFar, kFar);
  if (beyond == 0.0) return 0.0;
  return beyond > 0.0 ? kFar : -kFar;
}

double signOf(Better better) {
  return better == Better::kLower ? 1.0 : -1.0;
}

}  // namespace

BandJudgement judge(double value, const BandMetric& metric, double least_spread, double deviations) {
  BandJudgement result;
  const double share = metric.name == kLogarithmic ? 0.0 : least_spread;
  result.spread = std::max({metric.deviation, share * std::abs(metric.mean), metric.least});
  const bool is_always_zero = metric.mean == 0.0 && metric.deviation == 0.0;
  const double granted = is_always_zero ? metric.least : deviations * result.spread;
  const double sign = signOf(metric.better);
  result.limit = metric.mean + sign * granted;
  const double beyond = sign * (value - result.limit);
  result.passed = beyond <= 0.0;
  result.excess = std::isfinite(value) ? excessOf(beyond, result.spread) : kFar;
  return result;
}

BandJudgement judgeByLimit(double value, double limit, Better better) {
  BandJudgement result;
  result.limit = limit;
  const double beyond = signOf(better) * (value - limit);
  result.passed = beyond <= 0.0;
  result.excess = std::isfinite(value) ? excessOf(beyond, std::abs(limit)) : kFar;
  return result;
}

const BandMetric* find(const Band& band, const std::string& metric) {
  const auto found =
      std::find_if(band.metrics.begin(), band.metrics.end(), [&](const BandMetric& m) { return m.name == metric; });
  return found == band.metrics.end() ? nullptr : &*found;
}

}  // namespace raven2_trainer::training
