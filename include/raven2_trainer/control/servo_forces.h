#pragma once

#include <Eigen/Core>

#include "raven2_trainer/control/effort.h"
#include "raven2_trainer/control/servo.h"
#include "raven2_trainer/kinematics/arms_config.h"

// Forces and the Jacobian in the joints that CRTK clients use: shoulder to wrist, the jaws' mid-line, and in addition
// the jaws' opening. Pure; real-time safe.

namespace raven2_trainer::control {

using ServoJacobian = Eigen::Matrix<double, 6, 6>;

/** Columns ServoJoints; rows 0 to 2 [m/s] of the tip T in B per [rad/s; m/s], rows 3 to 5 [rad/s]. */
ServoJacobian servoJacobian(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept;

/** [Nm; N] Torques and forces on ServoJoints that do the same work as those on all seven joints. */
ServoJoints servoForces(const JointArray& tau) noexcept;
/** [Nm] Of the jaws' opening. */
double jawForce(const JointArray& tau) noexcept;
/** [Nm; N] On all seven joints: servoForces() and jawForce() backwards. */
JointArray jointForces(const ServoJoints& forces, double jaw) noexcept;

/** [Nm; N] On ServoJoints, of an arm at joints q: what `effort`, whose kind is not kNone, asks for. */
ServoJoints servoForces(const ArmGeometry& geometry, Arm arm, const JointArray& q, const Effort& effort) noexcept;

}  // namespace raven2_trainer::control
