#pragma once

#include <array>

#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"

// Shared by scripted and recorded motion. Positions of the robot's tips are in ITP axes I, from the tip at home.

namespace raven2_trainer::console {

/** Fraction of a minimum-jerk move at fraction `s` of its time (Flash and Hogan 1985, eq. 11); clamped to [0, 1]. */
double minimumJerk(double s) noexcept;

/** The same of a motion of `length` ticks that began at `start`. */
inline double fraction(Tick now, Tick start, Tick length) noexcept {
  return minimumJerk(static_cast<double>(now - start) / static_cast<double>(length));
}

/** W (x forward, y left, z up) to I (x forward, y right, z down), and back: a half turn about x. */
Vector3 worldToItp(const Vector3& v_W) noexcept;

/** A point in W as a displacement from the arm's tip at home, in I. */
Vector3 fromHome(const ArmsConfig& arms, Arm arm, const Vector3& p_W) noexcept;

/** The arm's tip at home in its base frame B [m]. */
Vector3 homeTip(const ArmsConfig& arms, Arm arm) noexcept;

/** Physiological tremor of one hand: on each axis a sum of seeded sinusoids, in all never above the amplitude. */
class Tremor {
 public:
  Tremor(const ConsoleConfig& config, Random* random);

  /** [m] [@frame I] at time `t` [s]. */
  Vector3 at(double t) const noexcept;

 private:
  static constexpr std::size_t kWaves = 3;
  struct Wave {
    double frequency{};  ///< [Hz]
    double phase{};      ///< [rad]
  };
  double wave_amplitude_;  ///< [m]
  std::array<std::array<Wave, kWaves>, 3> waves_{};
};

}  // namespace raven2_trainer::console
