#pragma once

#include <cstddef>
#include <vector>

namespace raven2_trainer::training {

/** Smallest power of two that is not below `n`; 1 for 0. */
std::size_t powerOfTwo(std::size_t n) noexcept;

/**
 * Magnitudes |X_k| of the discrete Fourier transform of real samples, padded with zeros to `length`:
 * X_k = sum over n of x_n exp(-2 pi i k n / length). Radix 2 (Cooley and Tukey), not for real-time threads.
 * @param[in] length a power of two, not below the number of samples. @throw std::invalid_argument otherwise.
 * @return `length` values; k and length - k are alike.
 */
std::vector<double> magnitudes(const std::vector<double>& samples, std::size_t length);

}  // namespace raven2_trainer::training
