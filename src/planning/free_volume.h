#pragma once

#include <cstdint>
#include <functional>

#include "planning/joint_space.h"

namespace raven2_trainer::planning {

/** Fraction of the unit cube that is free, mu(X_free), by Monte Carlo. */
struct FreeVolume {
  double mean{};   ///< [-] free samples / samples
  double upper{};  ///< [-] the true fraction is no more than this, with the confidence asked for
};

/**
 * Draws `samples` states uniformly and counts the free ones.
 *
 * The bound is Clopper and Pearson's, one-sided: the fraction at which so few free samples or fewer would be drawn with
 * probability 1 - confidence. It is exact (never less confident than asked) for any number of samples. The UPPER bound
 * is the safe side for FMT*: its radius grows with mu(X_free), and too small a radius loses asymptotic optimality.
 *
 * @param[in] samples at least 1. @param[in] confidence [-] in (0, 1).
 * @throw std::invalid_argument otherwise.
 */
FreeVolume estimateFreeVolume(const std::function<bool(const UnitState&)>& is_free,
                              std::uint32_t samples,
                              std::uint64_t seed,
                              double confidence);

/** One-sided upper Clopper-Pearson bound of a probability, from `hits` of `samples`. */
double upperBound(std::uint32_t hits, std::uint32_t samples, double confidence);

/** Volume of the unit ball in `dimension` dimensions. */
double unitBallVolume(int dimension);

/**
 * gamma of eq. (2) of the paper [-]: multiplier x 2 (1/d)^(1/d) (free_volume / zeta_d)^(1/d), zeta_d the volume of the
 * unit ball (Janson, Schmerling, Clark, Pavone 2015, theorem 4.1, where the multiplier is 1 + eta, eta > 0).
 */
double fmtGamma(double free_volume, double multiplier);

/** r_n of eq. (2) [-]: gamma (log n / n)^(1/d). @param[in] samples n, at least 2. */
double fmtRadius(double free_volume, double multiplier, std::uint32_t samples);

}  // namespace raven2_trainer::planning
