#pragma once

#include <memory>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/console/master.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {

/** The rows of a map as a matrix: v_I = axisMatrix(map) * v_device. */
Eigen::Matrix3d axisMatrix(const AxisMap& map) noexcept;

/**
 * Force for a device: `force_I` in the device's axes, at most config.max_force, in the driver's unit.
 * Zero if `force_I` is not finite. Real-time safe.
 */
Vec3 toDevice(const MasterConfig& config, const Vec3& force_I) noexcept;

/**
 * Checks what a device publishes: units, reach, jumps, rotations, silence, frozen poses. Call once a millisecond: it
 * measures time by its calls. Real-time safe.
 */
class DeviceWatch {
 public:
  explicit DeviceWatch(const MasterConfig& config) noexcept;

  /** @return the problem in this tick; if liftsPedal() of it, do not use the device. */
  DeviceFinding look(const DeviceSample& sample, bool engaged) noexcept;

  /** Reason not to engage although look() has found nothing. */
  DeviceFinding beforeStart() const noexcept;

 private:
  DeviceFinding judge(const DeviceSample& sample) const noexcept;
  DeviceFinding judgePlace(const Vector3& p, double elapsed) const noexcept;
  DeviceFinding judgeTurn(const Quat& q, double elapsed) const noexcept;
  void keep(const DeviceSample& sample) noexcept;

  const MasterConfig& config_;
  const bool has_pose_;
  std::uint32_t poses_{0};  ///< seen
  double age_{0.0};         ///< [s] of the newest
  double watched_{0.0};     ///< [s] since the first
  double unchanged_{0.0};   ///< [s] engaged, with the same pose
  bool has_place_{false}, has_moved_{false};
  Vector3 p_{0, 0, 0};  ///< [m] newest good position, the device's axes
  Quat q_{kIdentityQuat};
  Vector3 lowest_{0, 0, 0}, highest_{0, 0, 0};  ///< [m] of all good positions
  DeviceFinding found_;                         ///< in the newest pose
};

/**
 * Hands on one or two real devices, or on a gamepad. A press of the pedal counts if no problem is found. A device that
 * goes silent, jumps or leaves its reach lifts it; it must be released and pressed again. A hand starts at its first
 * pose after the press. Earlier motion moves nothing, even if it is reported late. Between poses slower than 1 kHz the
 * hand moves evenly: within the time since the last pose (at least the usual time, at most 20 ms), in steps that fit
 * into a packet at config.scale. Jaws move only while engaged, at config.jaw_speed; after a new press they catch up
 * with the finger. `link` must outlive it. Its tick() is real-time safe.
 * @param[in] jaws [rad] opening of each arm's jaws at the start.
 */
std::unique_ptr<MotionSource> makeDeviceSurgeon(const MasterConfig& config,
                                                const PerArm<double>& jaws,
                                                MasterLink* link);

}  // namespace raven2_trainer::console
