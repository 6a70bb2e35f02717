#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::raven {

/** Desired pose of one arm as the robot keeps it: whole micrometres and milliradians (raven2.md 1.4). Undefined
 * behaviour of the original's C
 *  does here what x86 does there: a double that is no int32 becomes -2^31, sums wrap. */
struct MasterTarget {
  std::array<std::int32_t, 3> p_um{};       ///< [um] [@frame B]
  Quaternion R_BT{Quaternion::Identity()};  ///< unit; NaN after an increment whose quaternion is zero or not finite
  std::int32_t grasp_mrad{};                ///< [mrad] wanted opening, grasp1 + grasp2

  /** Adds one packet's increments through the axis map. */
  void add(Arm arm, const wire::ItpPacket& packet) noexcept;

  /** Adds increments in the base frame, as /raven_automove carries them: [um], truncated; quaternion x y z w. */
  void addInBase(const Vec3& dp_um, const Quat& dq) noexcept;

  /** Takes over a pose, truncated to the micrometre, and grasp. */
  void set(const Pose& X_BT, double opening) noexcept;

  /** Takes over a pose, truncated to the micrometre, but not the grasp. */
  void setPose(const Pose& X_BT) noexcept;

  /** Takes over another target; the grasp only if it is off by more than 45 degrees. */
  void rebase(const MasterTarget& other) noexcept;

  Pose pose() const noexcept;
  bool isFinite() const noexcept { return R_BT.coeffs().allFinite(); }
  double opening() const noexcept { return grasp_mrad * 1e-3; }
};

/** Increments of one arm in the packet. [um] [@frame I] */
Vector3 incrementOf(const wire::ItpPacket& packet, Arm arm) noexcept;

}  // namespace raven2_trainer::raven
