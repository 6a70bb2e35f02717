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

/** Toward zero; what does not fit, and NaN, gives -2^31 (x86 cvttsd2si). */
std::int32_t truncate(double value) noexcept {
  if (value > -2147483649.0 && value < 2147483648.0) return static_cast<std::int32_t>(value);
  return std::numeric_limits<std::int32_t>::min();
}

std::int32_t wrappingAdd(std::int32_t a, std::int32_t b) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}

std::int32_t wrappingSubtract(std::int32_t a, std::int32_t b) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

Quaternion notANumber() noexcept {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  return {kNan, kNan, kNan, kNan};
}

/** As by way of the rotation matrix, with its 2 / |q|^2: 0/0 of a zero quaternion is NaN, a norm that overflows gives
 * the identity. */
Quaternion rotationOf(const Quaternion& q) noexcept {
  const double square = q.squaredNorm();
  if (!q.coeffs().allFinite() || !(square > 0.0)) return notANumber();
  if (std::isinf(square)) return Quaternion::Identity();
  return q.normalized();
}

Quaternion quaternionOf(const wire::ItpPacket& packet, Arm arm) noexcept {
  return {at(packet.Qw, arm), at(packet.Qx, arm), at(packet.Qy, arm), at(packet.Qz, arm)};
}

}  // namespace

Vector3 incrementOf(const wire::ItpPacket& packet, Arm arm) noexcept {
  return {static_cast<double>(at(packet.delx_um, arm)), static_cast<double>(at(packet.dely_um, arm)),
          static_cast<double>(at(packet.delz_um, arm))};
}

void MasterTarget::add(Arm arm, const wire::ItpPacket& packet) noexcept {
  const Matrix3& C = control::itpToBase(arm);
  Quaternion increment = rotationOf(quaternionOf(packet, arm));
  // Position and rotation go through one transform C X C^-1, so that a NaN in the rotation reaches the position.
  const double poison = 0.0 * increment.w();
  const Vector3 step_um = C * incrementOf(packet, arm);
  for (std::size_t i = 0; i < 3; ++i)
    p_um[i] = wrappingAdd(p_um[i], truncate(step_um[static_cast<Eigen::Index>(i)] + poison));

  // C q C^-1: the axis turns, the angle stays. Left-multiplied: the increment is in the base frame.
  increment.vec() = C * increment.vec();
  R_BT = rotationOf(increment * R_BT);

  const std::int32_t grasp = wrappingSubtract(grasp_mrad, at(packet.grasp_mrad, arm));
  grasp_mrad = std::clamp(grasp, kGraspMin, kGraspMax);
}

void MasterTarget::addInBase(const Vec3& dp_um, const Quat& dq) noexcept {
  for (std::size_t i = 0; i < 3; ++i)
    p_um[i] = wrappingAdd(p_um[i], truncate(dp_um[i]));
  R_BT = rotationOf(toEigen(dq) * R_BT);
}

void MasterTarget::setPose(const Pose& X_BT) noexcept {
  for (std::size_t i = 0; i < 3; ++i)
    p_um[i] = truncate(X_BT.p[static_cast<Eigen::Index>(i)] * 1e6);
  R_BT = Quaternion(X_BT.R).normalized();
}

void MasterTarget::set(const Pose& X_BT, double opening) noexcept {
  setPose(X_BT);
  grasp_mrad = truncate(opening * 1e3);
}

void MasterTarget::rebase(const MasterTarget& other) noexcept {
  p_um = other.p_um;
  R_BT = other.R_BT;
  if (std::abs(opening() - other.opening()) > kGraspResync) grasp_mrad = other.grasp_mrad;
}

Pose MasterTarget::pose() const noexcept {
  return {R_BT.toRotationMatrix(), Vector3(p_um[0], p_um[1], p_um[2]) * 1e-6};
}

}  // namespace raven2_trainer::raven
