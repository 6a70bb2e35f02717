#pragma once

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::control {

// [rad] Grasp clamps of the robot's software: -10 and 90 degrees, in its milliradians (raven2 local_io.cpp).
constexpr double kMinOpening = -0.174;
constexpr double kMaxOpening = 1.570;

/**
 * Increments to desired joints for one arm, by the robot's own rules (raven2.md 1.4, 2.3, 2.5). So the nominal model
 * follows the same commands to the same places. Increments are truncated to whole micrometres in frame B and added to
 * the desired position. Rotations multiply from the left in B. The analytic inverse picks the solution nearest to the
 * arm and refuses one too far. A joint at its limit re-bases the desired pose, so that the surgeon cannot wind up past
 * it. The desired position is in whole micrometres, as in the robot, also after re-basing. At a limit this happens
 * every tick: rounding unlike the robot's would accumulate to a millimetre in some seconds. Real-time safe.
 */
class TeleopMapper {
 public:
  TeleopMapper(const ArmGeometry& geometry, Arm arm) noexcept;

  /** The desired position and orientation become those of joints `q`, in whole micrometres. The wanted jaw opening
   *  stays, so that what is held stays held. */
  void rebasePose(const JointArray& q) noexcept;

  /** The robot's rule with the pedal up: rebasePose(), and the wanted opening too if it is more than 45 degrees from
   *  that of `q`, the robot's joints (raven2.md 1.4). */
  void rebase(const JointArray& q) noexcept;

  /** [rad] Wanted jaw opening. */
  double opening() const noexcept { return opening_; }
  /** From the next rebase or increment on. @param[in] opening [rad]. */
  void setOpening(double opening) noexcept { opening_ = opening; }

  /**
   * Adds one tick's increments.
   * @param[in] dp_I [m] [@frame I] position increment. @param[in] dq_I [@frame I] rotation increment.
   * @param[in] dgrasp [rad] positive closes. @param[in] current [rad; m] where the arm is.
   * @return kOk, kClamped (a limit was reached), kSingularWrist (goes on, roll kept where possible), or why the arm
   * stays: kOutOfReach, kSingularRcm, kTooFar.
   */
  kinematics::IkStatus add(const Vec3& dp_I, const Quat& dq_I, double dgrasp, const JointArray& current) noexcept;

  /** The last result of add(); kOk since a re-base. */
  kinematics::IkStatus status() const noexcept { return status_; }
  /** [rad; m] desired joints; unchanged by an increment that was refused. */
  const JointArray& desired() const noexcept { return q_d_; }
  /** Desired pose of the tip in B, refused increments included. */
  const Pose& desiredPose() const noexcept { return X_BTd_; }

 private:
  ArmGeometry geometry_;
  Arm arm_;
  Pose X_BTd_;    // its position is p_um_
  Vector3 p_um_;  // [um] whole numbers, so that model and robot round alike
  double opening_{};
  JointArray q_d_{};
  kinematics::IkStatus status_{kinematics::IkStatus::kOk};
};

}  // namespace raven2_trainer::control
