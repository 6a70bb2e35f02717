#pragma once

#include <Eigen/Core>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::kinematics {

/** Columns: joints 0..6; rows 0..2 linear [m/s], 3..5 angular [rad/s], both of T in B, expressed in B. */
using Jacobian = Eigen::Matrix<double, 6, 7>;

/** Outcome of inverse(). */
enum class IkStatus : std::uint32_t {
  kOk,
  kClamped,      ///< set by applyJointLimits' callers: a software limit was reached
  kOutOfReach,   ///< no solution puts the tip there
  kSingularRcm,  ///< the wrist would be within `lw` of the remote centre
  kTooFar,       ///< solutions exist, but none near enough to `current`: the robot refuses these too
};

/** Mid-line angle of the jaws, DH theta 6 [rad]: (grasp2 - grasp1) / 2 (raven2.md 2.3). */
double jawMidline(const JointArray& q) noexcept;

/** Opening angle of the jaws [rad]: grasp1 + grasp2. */
double jawOpening(const JointArray& q) noexcept;

/**
 * Pose of the tool tip T (DH frame 6) in the arm base frame B.
 * Modified (Craig) DH table of the real robot's software, raven2.md 2.1 and 2.2. Real-time safe.
 * @param[in] q [rad; m] robot joints.
 */
Pose forward(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept;

/** Geometric Jacobian at `q`; the grasper columns are those of the mid-line, -1/2 and +1/2. Real-time safe. */
Jacobian jacobian(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept;

struct IkResult {
  IkStatus status{IkStatus::kOutOfReach};
  JointArray q{};  ///< [rad; m] valid with kOk only
};

/**
 * Joints that put T at `X_BT`: the analytic inverse of the robot's software with all eight solutions, the one
 * nearest to `current` chosen as the robot does it (squared error, insertion times 100, roll unwrapped by one turn
 * where it differs by more than 300 degrees; refused above pi). raven2.md 2.5. Limits are not applied here.
 * Real-time safe.
 *
 * @param[in] X_BT Wanted pose of T in B.
 * @param[in] opening [rad] wanted jaw opening, grasp1 + grasp2.
 * @param[in] current [rad; m] joints now.
 */
IkResult inverse(const ArmGeometry& geometry,
                 Arm arm,
                 const Pose& X_BT,
                 double opening,
                 const JointArray& current) noexcept;

/**
 * Clamps as the robot does: joints 0 to 4 at both limits, grasp1 at its lower one (raven2.md 2.3). Real-time safe.
 * @return true if any joint was changed.
 */
bool applyJointLimits(const ArmGeometry& geometry, JointArray* q) noexcept;

}  // namespace raven2_trainer::kinematics
