#include "raven2_trainer/training/smoothness.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/training/fft.h"

namespace raven2_trainer::training {

namespace {

constexpr std::size_t kLeastSamples = 4;  // of a third difference
constexpr std::size_t kPadding = 16;      // times the samples' power of two: level 4 of the paper
constexpr double kHighest = 10.0;         // [Hz] hands do nothing on purpose beyond it
constexpr double kThreshold = 0.05;       // [-] of the greatest magnitude
// [-] Rounding of a constant speed gives up to 1e-20; a minimum-jerk stroke has 205.
constexpr double kNoJerk = 1e-9;

bool allFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

double largest(const std::vector<double>& values) {
  double peak = 0.0;
  for (const double v : values)
    peak = std::max(peak, std::abs(v));
  return peak;
}

bool isUsable(const std::vector<double>& speed) {
  return speed.size() >= kLeastSamples && allFinite(speed) && largest(speed) > 0.0;
}

double squaredJerk(const std::vector<double>& speed, double rate) {
  double sum = 0.0;
  for (std::size_t k = 2; k < speed.size(); ++k) {
    const double jerk = (speed[k] - 2.0 * speed[k - 1] + speed[k - 2]) * rate * rate;
    sum += jerk * jerk;
  }
  return sum;
}

/** Normalised spectrum from the first to the last bin that reaches the threshold, up to kHighest. */
std::vector<double> significantSpectrum(const std::vector<double>& speed, double rate) {
  const std::size_t length = powerOfTwo(speed.size()) * kPadding;
  std::vector<double> spectrum = magnitudes(speed, length);
  const double peak = largest(spectrum);
  const auto bins = static_cast<std::size_t>(kHighest / (rate / static_cast<double>(length))) + 1;
  spectrum.resize(std::min(bins, length));
  for (double& magnitude : spectrum)
    magnitude /= peak;
  const auto counts = [](double magnitude) { return magnitude >= kThreshold; };
  const auto first = std::find_if(spectrum.begin(), spectrum.end(), counts);
  const auto last = std::find_if(spectrum.rbegin(), spectrum.rend(), counts).base();
  return first < last ? std::vector<double>(first, last) : std::vector<double>{};
}

}  // namespace

std::optional<double> spectralArcLength(const std::vector<double>& speed, double rate) {
  if (!isUsable(speed)) return std::nullopt;
  const std::vector<double> spectrum = significantSpectrum(speed, rate);
  if (spectrum.size() < 2) return std::nullopt;
  const double step = 1.0 / static_cast<double>(spectrum.size() - 1);  // of the frequency axis made 1 long
  double length = 0.0;
  for (std::size_t k = 1; k < spectrum.size(); ++k)
    length += std::hypot(step, spectrum[k] - spectrum[k - 1]);
  return -length;
}

std::optional<double> dimensionlessJerk(const std::vector<double>& speed, double rate) {
  return dimensionlessJerk(std::vector<std::vector<double>>{speed}, rate);
}

std::optional<double> dimensionlessJerk(const std::vector<std::vector<double>>& speeds, double rate) {
  double sum = 0.0, peak = 0.0;
  std::size_t samples = 0;
  for (const std::vector<double>& speed : speeds) {
    if (!allFinite(speed)) return std::nullopt;
    sum += squaredJerk(speed, rate);
    peak = std::max(peak, largest(speed));
    samples += speed.size();
  }
  if (samples < kLeastSamples || !(peak > 0.0)) return std::nullopt;
  const double duration = static_cast<double>(samples) / rate;
  return -duration * duration * duration / (peak * peak) * sum / rate;
}

std::optional<double> logDimensionlessJerk(const std::vector<double>& speed, double rate) {
  return logDimensionlessJerk(std::vector<std::vector<double>>{speed}, rate);
}

std::optional<double> logDimensionlessJerk(const std::vector<std::vector<double>>& speeds, double rate) {
  const std::optional<double> jerk = dimensionlessJerk(speeds, rate);
  if (!jerk || std::abs(*jerk) < kNoJerk) return std::nullopt;
  return -std::log(std::abs(*jerk));
}

std::optional<double> meanJerk(const std::vector<Vec3>& places, double rate) {
  if (places.size() < kLeastSamples) return std::nullopt;
  double sum = 0.0;
  for (std::size_t k = 3; k < places.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double third = places[k][i] - 3.0 * places[k - 1][i] + 3.0 * places[k - 2][i] - places[k - 3][i];
      const double jerk = third * rate * rate * rate;
      sum += jerk * jerk;
    }
  }
  if (!std::isfinite(sum)) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(places.size() - 3));
}

}  // namespace raven2_trainer::training
