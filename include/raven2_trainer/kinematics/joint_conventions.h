#pragma once

#include "raven2_trainer/core/types.h"

// The robot's joint coordinates (raven2.md 2.3: every q in this package) and those of the URDF and of the robot's
// /joint_states (raven2.md 5.4). L is gold, R is green.

namespace raven2_trainer::kinematics {

/** Names of the URDF joints of an arm, in Joint order: shoulder_L, elbow_L, insertion_L, tool_roll_L, ... */
const std::array<const char*, kJointCount>& urdfJointNames(Arm arm) noexcept;

/** Position in URDF coordinates: insertion + d4, tool roll -45 (L) or +45 (R) degrees, wrist negated on R, grasper 2
 *  negated. @param[in] d4 [m] ArmGeometry::d4. */
JointArray toUrdf(Arm arm, double d4, const JointArray& q) noexcept;

/** Inverse of toUrdf(). */
JointArray fromUrdf(Arm arm, double d4, const JointArray& urdf) noexcept;

/** Velocity or, the map being diagonal with +-1, torque. Its own inverse. */
JointArray rateToUrdf(Arm arm, const JointArray& rate) noexcept;

}  // namespace raven2_trainer::kinematics
