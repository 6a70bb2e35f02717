#include "raven/master_target.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raven2_trainer/control/axis_map.h"

namespace raven2_trainer::raven {
namespace {

constexpr std::int32_t kGraspMin = -174;  // [mrad] -10 degrees, raven2 local_io.cpp:187-208
constexpr std::int32_t kGraspMax = 1570;  // [mrad] 90 degrees
constexpr double kGraspResync = 45.0 * kPi / 180.0;
constexpr double kLeastNorm = 1e-6;

/** Toward zero, as a C cast does where it is defined. */
std::int32_t truncate(double value) noexcept {
  constexpr double kLow = std::numeric_limits<std::int32_t>::min();
  constexpr double kHigh = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::clamp(value, kLow, kHigh));
}

/** Wraps as the robot's 32-bit addition does in practice. */
std::int32_t wrappingAdd(std::int32_t a, std::int32_t b) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}

Quaternion quaternionOf(const wire::ItpPacket& packet, Arm arm) noexcept {
  return {at(packet.Qw, arm), at(packet.Qx, arm), at(packet.Qy, arm), at(packet.Qz, arm)};
}

}  // namespace

Vector3 incrementOf(const wire::ItpPacket& packet, Arm arm) noexcept {
  return {static_cast<double>(at(packet.delx_um, arm)), static_cast<double>(at(packet.dely_um, arm)),
          static_cast<double>(at(packet.delz_um, arm))};
}

Reject checkQuaternions(const wire::ItpPacket& packet) noexcept {
  for (const Arm arm : kArms) {
    const double norm = quaternionOf(packet, arm).norm();
    if (!std::isfinite(norm)) return Reject::kNotFinite;
    if (norm < kLeastNorm) return Reject::kBadQuaternion;
  }
  return Reject::kNone;
}

void MasterTarget::add(Arm arm, const wire::ItpPacket& packet) noexcept {
  const Matrix3& C = control::itpToBase(arm);
  const Vector3 step_um = C * incrementOf(packet, arm);
  for (std::size_t i = 0; i < 3; ++i)
    p_um[i] = wrappingAdd(p_um[i], truncate(step_um[static_cast<Eigen::Index>(i)]));

  // C q C^-1: the axis turns, the angle stays. Left-multiplied: the increment is in the base frame.
  Quaternion increment = quaternionOf(packet, arm).normalized();
  increment.vec() = C * increment.vec();
  R_BT = (increment * R_BT).normalized();

  const std::int64_t grasp = static_cast<std::int64_t>(grasp_mrad) - at(packet.grasp_mrad, arm);
  grasp_mrad = static_cast<std::int32_t>(std::clamp<std::int64_t>(grasp, kGraspMin, kGraspMax));
}

void MasterTarget::rebasePose(const Pose& X_BT) noexcept {
  for (std::size_t i = 0; i < 3; ++i)
    p_um[i] = truncate(X_BT.p[static_cast<Eigen::Index>(i)] * 1e6);
  R_BT = Quaternion(X_BT.R).normalized();
}

void MasterTarget::rebase(const Pose& X_BT, double actual_opening) noexcept {
  rebasePose(X_BT);
  if (std::abs(actual_opening - opening()) > kGraspResync) grasp_mrad = truncate(actual_opening * 1e3);
}

Pose MasterTarget::pose() const noexcept {
  return {R_BT.toRotationMatrix(), Vector3(p_um[0], p_um[1], p_um[2]) * 1e-6};
}

}  // namespace raven2_trainer::raven
