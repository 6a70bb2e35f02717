#pragma once

#include <array>

#include "raven2_trainer/control/arm_controller.h"
#include "raven2_trainer/core/command.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::control {

/** The increment of one ITP packet, in master axes I. */
struct TipIncrement {
  Vec3 dp_I{};               ///< [m] whole micrometres
  Quat dq_I{kIdentityQuat};  ///< left-multiplied, as ITP's
};

/** Largest increments that a receiver accepts in one packet. */
struct IncrementLimits {
  double position_um{};  ///< [um] each axis of I
  double rotation{};     ///< [rad]
};

/**
 * Desired joints of the model to tip increments of one arm, such that the robot's own inverse kinematics comes to the
 * same joints. Keeps the pose that the robot has added up by its rules (raven2.md 1.4: whole micrometres, rotations
 * from the left), and sends the difference to the path. So the rounding error of one packet is in the next
 * one. The sum is within half a micrometre an axis of the path, for any length. Pure; real-time safe.
 */
class PathRelay {
 public:
  PathRelay(const ArmGeometry& geometry, const IncrementLimits& limits) noexcept
      : geometry_(geometry), limits_(limits) {}

  /** The robot starts from the joints `q` [rad; m]: its desired pose is theirs, in micrometres cut off toward zero. */
  void start(Arm arm, const JointArray& q) noexcept;

  /** The increment from the robot's desired pose to that of the joints `q` [rad; m], as far as a packet can hold it. */
  TipIncrement advance(const JointArray& q) noexcept;

  /** The last increment was all that was missing. */
  bool isUpToDate() const noexcept { return is_up_to_date_; }
  /** Desired pose of T in B that the robot has by now. */
  Pose pose() const noexcept { return {R_BT_.toRotationMatrix(), p_um_ * 1e-6}; }

 private:
  Vector3 positionStep(const Vector3& p_BT) noexcept;
  Quaternion rotationStep(const Quaternion& R_BT) noexcept;

  ArmGeometry geometry_;
  IncrementLimits limits_;
  Arm arm_{Arm::kGold};
  Vector3 p_um_{0, 0, 0};  ///< whole numbers
  Quaternion R_BT_{Quaternion::Identity()};
  bool is_up_to_date_{true};
};

/** How far from the path's joints the robot's may come to be by the rounding of its desired position [rad; m]: near the
 *  remote centre half a micrometre turns the shoulder by 50 urad. Another branch of the inverse is ten times as far. */
constexpr std::array<double, kGrasp1> kFollowTolerance{2e-3, 2e-3, 5e-5, 1e-2, 1e-2};

/**
 * Whether increments can lead a robot along a plan's path. Every 5 ms of it the robot's inverse kinematics starts from
 * the pose that the packets add up to and from the joints 5 ms before. It must come within kFollowTolerance to the
 * joints of `law` on the path, without reaching a limit or filling a packet. Not for the 1 kHz loops: microseconds a
 * step.
 */
bool robotFollows(const ArmGeometry& geometry,
                  const IncrementLimits& limits,
                  const ArmController& law,
                  const PlanResult& plan) noexcept;

}  // namespace raven2_trainer::control
