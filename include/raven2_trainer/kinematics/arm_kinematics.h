#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::kinematics {

/** Columns: joints 0..6; rows 0..2 linear [m/s], 3..5 angular [rad/s], both of T in B, expressed in B. */
using Jacobian = Eigen::Matrix<double, 6, 7>;

/** Outcome of inverse() and inverseWithinLimits(). The numbers are in session logs: new ones go to the end. */
enum class IkStatus : std::uint32_t {
  kOk,
  kClamped,       ///< a software limit was reached: usable, but the tip is not at the wanted pose
  kOutOfReach,    ///< no solution puts the tip there, or the input is not finite
  kSingularRcm,   ///< the wrist would be within `lw` of the remote centre
  kTooFar,        ///< solutions exist, but none near enough to `current`: the robot refuses these too
  kSingularWrist  ///< usable: the tip is at the pose, but the jaw axis passes the remote centre within 10 um, so that
                  ///< roll, wrist and jaw line are not settled by the pose
};

/** True if the joints of a result with this status may be used: kOk, kClamped, kSingularWrist. */
constexpr bool isUsable(IkStatus status) noexcept {
  return status == IkStatus::kOk || status == IkStatus::kClamped || status == IkStatus::kSingularWrist;
}

/** ok, clamped, out_of_reach, singular_rcm, too_far, singular_wrist. */
const char* name(IkStatus status) noexcept;

/** Mid-line angle of the jaws, DH theta 6 [rad]: (grasp2 - grasp1) / 2 (raven2.md 2.3). */
double jawMidline(const JointArray& q) noexcept;

/** Opening angle of the jaws [rad]: grasp1 + grasp2. */
double jawOpening(const JointArray& q) noexcept;

/** Sets both graspers: the inverse of the two above. @param[in] midline, opening [rad]. */
void setJaws(double midline, double opening, JointArray* q) noexcept;

/**
 * Pose of the tool tip T (DH frame 6) in the arm base frame B.
 * Modified (Craig) DH table of the real robot's software, raven2.md 2.1 and 2.2. Real-time safe.
 * @param[in] q [rad; m] robot joints.
 */
Pose forward(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept;

/** Geometric Jacobian at `q`; the grasper columns are those of the mid-line, -1/2 and +1/2. Real-time safe. */
Jacobian jacobian(const ArmGeometry& geometry, Arm arm, const JointArray& q) noexcept;

/** Pose of T in B and its velocity [m/s] in B: forward(), and the upper half of jacobian() times `dq`, for less. */
struct TipMotion {
  Pose X_BT;
  Vector3 v_BT;
};
TipMotion tipMotion(const ArmGeometry& geometry, Arm arm, const JointArray& q, const JointArray& dq) noexcept;

struct IkResult {
  IkStatus status{IkStatus::kOutOfReach};
  JointArray q{};  ///< [rad; m] valid if isUsable(status), else zero; never NaN
};

/** One of the eight ways to reach a pose. */
struct IkSolution {
  bool valid{false};
  JointArray q{};  ///< [rad; m] all angles but the graspers' in [-pi, pi]; not limited
};

/** By choice: wrist point on the far or near side of the tip (4 each), insertion below or above the remote centre
 *  (2 each), elbow one way or the other. */
using IkSolutions = std::array<IkSolution, 8>;

/**
 * All joints that put T at `X_BT` (raven2.md 2.5); limits are not applied. Each valid solution put through forward()
 * gives the pose back; only within 1e-5 of the elbow's reach, which the robot rounds, is it met to 1e-5 of the
 * insertion. Real-time safe.
 *
 * @param[in] X_BT Wanted pose of T in B; X_BT.R must be a rotation.
 * @param[in] opening [rad] wanted jaw opening, grasp1 + grasp2.
 * @return kOk; kSingularWrist (where the jaw axis meets the remote centre there are infinitely many solutions: those
 *         with one jaw line are given); kOutOfReach or kSingularRcm without a valid one.
 */
IkStatus inverseAll(const ArmGeometry& geometry,
                    Arm arm,
                    const Pose& X_BT,
                    double opening,
                    IkSolutions* solutions) noexcept;

/**
 * Joints that put T at `X_BT`: of inverseAll() the one nearest to `current`, chosen as the robot does it. It uses the
 * squared error with insertion times 100. Roll is unwrapped by one revolution where it differs by more than 300
 * degrees. Above pi it refuses. raven2.md 2.5. Limits are not applied. Where the jaw axis meets the remote centre, roll
 * stays that of `current` (or near it, if the arm cannot keep it) and the status is kSingularWrist. Real-time safe.
 *
 * @param[in] X_BT Wanted pose of T in B; X_BT.R must be a rotation.
 * @param[in] opening [rad] wanted jaw opening, grasp1 + grasp2.
 * @param[in] current [rad; m] joints now.
 * @return any status but kClamped.
 */
IkResult inverse(const ArmGeometry& geometry,
                 Arm arm,
                 const Pose& X_BT,
                 double opening,
                 const JointArray& current) noexcept;

/** inverse(), then applyJointLimits(): kClamped if that changed the joints. Real-time safe. */
IkResult inverseWithinLimits(const ArmGeometry& geometry,
                             Arm arm,
                             const Pose& X_BT,
                             double opening,
                             const JointArray& current) noexcept;

/** The first of the two wrist points (step 1 of raven2.md 2.5) within lw of the remote centre: the robot's inverse
 * gives up there, whatever the second one offers. Real-time safe. */
bool isFirstWristPointAtRcm(const ArmGeometry& geometry, const Pose& X_BT) noexcept;

/**
 * Clamps as the robot does: joints 0 to 4 at both limits, the jaws' mid-line at grasp1's lower one (raven2.md 2.3).
 * Real-time safe.
 * @return true if any joint was changed.
 */
bool applyJointLimits(const ArmGeometry& geometry, JointArray* q) noexcept;

}  // namespace raven2_trainer::kinematics
