#pragma once

#include <optional>
#include <vector>

#include "raven2_trainer/core/types.h"

// How smooth a movement is. All take samples of one rate [Hz], in any unit of length, and give nothing where there is
// nothing to say: fewer than four samples, a value that is not finite, or no motion.

namespace raven2_trainer::training {

/**
 * Spectral arc length [-]: less than 0, the nearer to 0 the smoother (Balasubramanian, Melendez-Calderon, Roby-Brami,
 * Burdet, J. NeuroEng. Rehabil. 12:112, 2015; its siva82kb/SPARC with padding 4, 10 Hz, threshold 0.05).
 */
std::optional<double> spectralArcLength(const std::vector<double>& speed, double rate);

/** Dimensionless jerk [-], at most 0: -(T^3 / v_peak^2) times the integral of (d2v/dt2)^2, T = samples / rate. */
std::optional<double> dimensionlessJerk(const std::vector<double>& speed, double rate);

/** The same of a motion with cuts in it: T of all pieces together, no difference over a cut. */
std::optional<double> dimensionlessJerk(const std::vector<std::vector<double>>& speeds, double rate);

/** -ln |dimensionlessJerk()| [-], the greater the smoother; nothing for constant speed. */
std::optional<double> logDimensionlessJerk(const std::vector<double>& speed, double rate);
std::optional<double> logDimensionlessJerk(const std::vector<std::vector<double>>& speeds, double rate);

/** Root of the mean square of the third difference quotient of places [length/s^3]. */
std::optional<double> meanJerk(const std::vector<Vec3>& places, double rate);

}  // namespace raven2_trainer::training
