#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::raven {

/** Desired pose of one arm as the robot keeps it: whole micrometres and milliradians (raven2.md 1.4). */
struct MasterTarget {
  std::array<std::int32_t, 3> p_um{};       ///< [um] [@frame B]
  Quaternion R_BT{Quaternion::Identity()};  ///< unit
  std::int32_t grasp_mrad{};                ///< [mrad] wanted opening, grasp1 + grasp2

  /** Adds one packet's increments through the axis map. The quaternion must be finite and not zero. */
  void add(Arm arm, const wire::ItpPacket& packet) noexcept;

  /** Takes over a pose, truncated to the micrometre; the grasp only if it is off by more than 45 degrees. */
  void rebase(const Pose& X_BT, double opening) noexcept;

  /** Takes over a pose but not the grasp. */
  void rebasePose(const Pose& X_BT) noexcept;

  Pose pose() const noexcept;
  double opening() const noexcept { return grasp_mrad * 1e-3; }
};

/** Increments of one arm in the packet. [um] [@frame I] */
Vector3 incrementOf(const wire::ItpPacket& packet, Arm arm) noexcept;

/** kNone, kNotFinite or kBadQuaternion (norm under 1e-6). The real robot has no such test and turns into NaN; an
 *  emulation must not. */
Reject checkQuaternions(const wire::ItpPacket& packet) noexcept;

}  // namespace raven2_trainer::raven
