#pragma once

#include "raven2_trainer/physics/raven_world.h"

// A plain PD with gravity held, as the owner of a world would drive it.

namespace raven2_trainer::physics::testing {

constexpr JointArray kStiffness{200.0, 200.0, 5000.0, 0.7, 1.0, 1.0, 1.0};
constexpr JointArray kDamping{8.0, 8.0, 400.0, 0.02, 0.03, 0.03, 0.03};

inline JointArray drive(const RavenWorld& world, Arm arm, const JointArray& target) {
  JointArray q, dq;
  world.jointState(arm, &q, &dq);
  JointArray tau = world.gravityTorque(arm);
  for (std::size_t j = 0; j < kJointCount; ++j)
    tau[j] += kStiffness[j] * (target[j] - q[j]) - kDamping[j] * dq[j];
  return tau;
}

inline void driveStep(RavenWorld* world, const PerArm<JointArray>& target) {
  world->step({drive(*world, Arm::kGold, target[0]), drive(*world, Arm::kGreen, target[1])});
}

inline JointArray position(const RavenWorld& world, Arm arm) {
  JointArray q, dq;
  world.jointState(arm, &q, &dq);
  return q;
}

inline JointArray rate(const RavenWorld& world, Arm arm) {
  JointArray q, dq;
  world.jointState(arm, &q, &dq);
  return dq;
}

/** Targets that press both tools into the floor of makeFloorAndRing() and stir there. */
inline PerArm<JointArray> stirringTarget(const JointArray& home, int step) {
  const double t = step * kTickSeconds;
  JointArray q = home;
  q[kShoulder] += 0.1 * std::sin(2.0 * t);
  q[kElbow] += 0.1 * std::sin(3.0 * t);
  q[kInsertion] = std::max(0.33, home[kInsertion] - 0.1 * t);
  q[kToolRotation] += std::sin(t);
  return {q, q};
}

}  // namespace raven2_trainer::physics::testing
