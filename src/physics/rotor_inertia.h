#pragma once

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::physics {

/**
 * Inertia of the motors as the joints feel it [kg m2; kg for kInsertion] (MuJoCo's "armature"): rotor inertia at the
 * motor's shaft times transmission squared (raven2.md 3.2), the cable coupling left out (paper, 2.3.1).
 *
 * Positioning axes: raven2.md 6.2 gives 2.847e-4 as capstan torque per motor acceleration, so 2.847e-4 / 12.25 at the
 * shaft (a maxon RE40 alone has 1.4e-5). A fit to the recording of the real gold arm (gold_arm_dac_motor_a.csv) gives
 * 3.5e-4 and 2.7e-4 for shoulder and elbow, links included, in the same units, and excludes a twelfth of it.
 * Tool axes: the maxon RE30's rotor, 3.35e-6 kg m2.
 *
 * The rotors are most of what the joints move: 0.43 of about 0.55 kg m2 at the shoulder, nearly all at the tool, where
 * the bare links (1e-7 to 1e-6 kg m2) could not be controlled at 1 kHz with the robot's stiffness (kd < 2 I / h).
 */
constexpr JointArray rotorInertia() noexcept {
  constexpr JointArray kTransmission{136.19625551, 121.52207496, 2158.59030837, 5.39517625,
                                     8.99196042,   8.99196042,   8.99196042};
  constexpr double kPositioningRotor = 2.847e-4 / 12.25, kToolRotor = 3.35e-6;
  JointArray inertia{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double rotor = j < kToolRotation ? kPositioningRotor : kToolRotor;
    inertia[j] = rotor * kTransmission[j] * kTransmission[j];
  }
  return inertia;
}

}  // namespace raven2_trainer::physics
