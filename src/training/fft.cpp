#include "raven2_trainer/training/fft.h"

#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::training {

namespace {

using Complex = std::complex<double>;

/** Puts every element where its index read backwards in bits says. */
void reverseBits(std::vector<Complex>* x) {
  const std::size_t n = x->size();
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1U;
    for (; (j & bit) != 0; bit >>= 1U)
      j ^= bit;
    j ^= bit;
    if (i < j) std::swap((*x)[i], (*x)[j]);
  }
}

/** exp(-2 pi i k / n) for k < n / 2, each from its own angle: products of one of them would gather rounding. */
std::vector<Complex> rootsOfUnity(std::size_t n) {
  std::vector<Complex> roots;
  roots.reserve(n / 2);
  for (std::size_t k = 0; k < n / 2; ++k)
    roots.push_back(std::polar(1.0, -2.0 * kPi * static_cast<double>(k) / static_cast<double>(n)));
  return roots;
}

void transform(std::vector<Complex>* x) {
  const std::size_t n = x->size();
  const std::vector<Complex> roots = rootsOfUnity(n);
  reverseBits(x);
  for (std::size_t half = 1; half < n; half *= 2) {
    for (std::size_t i = 0; i < n; ++i) {
      if ((i & half) != 0) continue;
      const Complex odd = (*x)[i + half] * roots[(i & (half - 1)) * (n / (2 * half))];
      (*x)[i + half] = (*x)[i] - odd;
      (*x)[i] += odd;
    }
  }
}

}  // namespace

std::size_t powerOfTwo(std::size_t n) noexcept {
  std::size_t power = 1;
  while (power < n)
    power *= 2;
  return power;
}

std::vector<double> magnitudes(const std::vector<double>& samples, std::size_t length) {
  if (length < samples.size() || powerOfTwo(length) != length) {
    throw std::invalid_argument("magnitudes: length " + std::to_string(length) + " for " +
                                std::to_string(samples.size()) + " samples, expected a power of two that holds them");
  }
  std::vector<Complex> x(samples.begin(), samples.end());
  x.resize(length);
  transform(&x);
  std::vector<double> result;
  result.reserve(length);
  for (const Complex& value : x)
    result.push_back(std::abs(value));
  return result;
}

}  // namespace raven2_trainer::training
