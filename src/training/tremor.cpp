#include "raven2_trainer/training/tremor.h"

#include <cmath>

#include "raven2_trainer/training/fft.h"

namespace raven2_trainer::training {

namespace {

/** Subtracts its least-squares line: the slope of a moving hand would be in every bin. */
void takeLineOut(std::vector<double>* x) {
  const auto n = static_cast<double>(x->size());
  const double middle = 0.5 * (n - 1.0);
  double mean = 0.0, slope = 0.0;
  for (std::size_t k = 0; k < x->size(); ++k) {
    mean += (*x)[k] / n;
    slope += (*x)[k] * (static_cast<double>(k) - middle);
  }
  slope /= n * (n * n - 1.0) / 12.0;
  for (std::size_t k = 0; k < x->size(); ++k)
    (*x)[k] -= mean + slope * (static_cast<double>(k) - middle);
}

/** @return the sum of the window's squares. */
double applyHann(std::vector<double>* x) {
  double sum = 0.0;
  for (std::size_t k = 0; k < x->size(); ++k) {
    const double w = 0.5 - 0.5 * std::cos(2.0 * kPi * static_cast<double>(k) / static_cast<double>(x->size()));
    (*x)[k] *= w;
    sum += w * w;
  }
  return sum;
}

double bandPower(std::vector<double> x, double rate) {
  takeLineOut(&x);
  const double window = applyHann(&x);
  const std::size_t length = powerOfTwo(x.size());
  const std::vector<double> spectrum = magnitudes(x, length);
  double sum = 0.0;
  for (std::size_t k = 1; k < length / 2; ++k) {
    const double frequency = static_cast<double>(k) * rate / static_cast<double>(length);
    if (frequency >= kTremorLow && frequency <= kTremorHigh) sum += 2.0 * spectrum[k] * spectrum[k];
  }
  return sum / (static_cast<double>(length) * window);
}

}  // namespace

std::vector<double> tremorPowers(const std::vector<Vec3>& places, double rate) {
  const auto second = static_cast<std::ptrdiff_t>(rate);
  std::vector<double> powers;
  for (std::ptrdiff_t first = 0; first + second <= static_cast<std::ptrdiff_t>(places.size()); first += second / 2) {
    const auto begin = places.begin() + first;
    if (const std::optional<double> power = tremorPower({begin, begin + second}, rate)) powers.push_back(*power);
  }
  return powers;
}

std::optional<double> tremorPower(const std::vector<Vec3>& places, double rate) {
  if (places.size() < 4 || static_cast<double>(places.size()) < rate) return std::nullopt;
  double power = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> x;
    x.reserve(places.size());
    for (const Vec3& place : places)
      x.push_back(place[axis]);
    power += bandPower(x, rate);
  }
  if (!std::isfinite(power)) return std::nullopt;
  return power;
}

}  // namespace raven2_trainer::training
