#pragma once

#include <cmath>
#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/**
 * Seeded generator (PCG-XSH-RR 64/32, O'Neill 2014, www.pcg-random.org). Not `<random>`: its distributions differ
 * between standard libraries, and the same seed must give the same session, byte by byte.
 */
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 1) noexcept : increment_((stream << 1U) | 1U) {
    next();
    state_ += seed;
    next();
  }

  /** Uniform 32-bit integer. */
  std::uint32_t next() noexcept {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ULL + increment_;
    const auto shifted = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
    const auto rotation = static_cast<std::uint32_t>(old >> 59U);
    return (shifted >> rotation) | (shifted << ((32U - rotation) & 31U));
  }

  /** Uniform in [low, high). */
  double uniform(double low, double high) noexcept {
    return low + (high - low) * (static_cast<double>(next()) / 4294967296.0);
  }

  /** Normal with mean 0 and deviation 1 (Box-Muller). */
  double normal() noexcept {
    const double u = 1.0 - uniform(0.0, 1.0);  // in (0, 1]
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * kPi * uniform(0.0, 1.0));
  }

 private:
  std::uint64_t state_{0};
  std::uint64_t increment_;
};

}  // namespace raven2_trainer
