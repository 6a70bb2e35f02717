#pragma once

#include <optional>
#include <vector>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::training {

// Physiological tremor of hands is 8 to 12 Hz (as that of config/console.yaml); 2 Hz of margin on both sides.
constexpr double kTremorLow = 6.0;    ///< [Hz]
constexpr double kTremorHigh = 14.0;  ///< [Hz]

/**
 * Mean square [length^2], all three axes together, of what places do between kTremorLow and kTremorHigh: straight line
 * taken out, Hann window, spectrum, Parseval. Nothing for fewer than `rate` places (a second) or one not finite.
 */
std::optional<double> tremorPower(const std::vector<Vec3>& places, double rate);

/** The same of each second, by half of which they overlap: tremor is in all of them, what a quick stroke has at these
 *  frequencies in few. */
std::vector<double> tremorPowers(const std::vector<Vec3>& places, double rate);

}  // namespace raven2_trainer::training
