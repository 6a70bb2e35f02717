#include "raven2_trainer/wire/itp.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/bytes.h"
#include "wire/sealed_packet.h"

namespace raven2_trainer::wire {
namespace {

constexpr double kMicrometresPerMetre = 1e6;
constexpr double kMilliPerUnit = 1e3;  ///< mrad per rad, mN per N

constexpr double kUsableNorm = 1e-6;  // far above where squares underflow

/** Whole range of the robot's jaw command, -10 to 90 degrees (raven2.md 1.4): no honest increment is larger. */
constexpr std::int32_t kMaxGraspIncrementMrad = 1745;

constexpr std::int32_t kMaxRunLevel = 3;

constexpr std::size_t kItpWords = 3 + 6 + 6;  // three of the header, increments, buttons, grasp, mode, checksum
static_assert(kItpWords * sizeof(std::int32_t) + 8 * sizeof(double) == kItpSize, "u_struct is packed, 124 bytes");
constexpr std::size_t kForceWords = 13;
static_assert(kForceWords * sizeof(std::int32_t) == kForceSize, "v_struct is packed, 52 bytes");

template <typename T>
void putPair(ByteWriter& out, const PerArm<T>& pair) noexcept {
  out.put(pair[0]);
  out.put(pair[1]);
}

template <typename T>
void getPair(ByteReader& in, PerArm<T>* pair) noexcept {
  (*pair)[0] = in.get<T>();
  (*pair)[1] = in.get<T>();
}

/** Nearest int32, saturated; NaN gives 0. */
std::int32_t toInt32(double value) noexcept {
  if (std::isnan(value)) return 0;
  return static_cast<std::int32_t>(std::llround(std::clamp(value, -2147483647.0, 2147483647.0)));
}

/** Sums wrap as the robot's signed int does on its hardware; unsigned arithmetic makes that defined. */
std::uint32_t bits(std::int32_t value) noexcept {
  return static_cast<std::uint32_t>(value);
}

Reject checkQuaternion(double x, double y, double z, double w) noexcept {
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (!std::isfinite(norm)) return Reject::kNotFinite;
  return norm < kQuaternionNormMin || norm > kQuaternionNormMax ? Reject::kBadQuaternion : Reject::kNone;
}

bool isWithin(std::int32_t value, std::int32_t limit) noexcept {
  return value >= -limit && value <= limit;
}

bool isInRange(const ItpPacket& packet, std::size_t arm, std::int32_t max_increment_um) noexcept {
  return isWithin(packet.delx_um[arm], max_increment_um) && isWithin(packet.dely_um[arm], max_increment_um) &&
         isWithin(packet.delz_um[arm], max_increment_um) && isWithin(packet.grasp_mrad[arm], kMaxGraspIncrementMrad);
}

/** Angle of a rotation of about unit norm; q and -q are the same rotation. [rad] */
double angleOf(const ItpPacket& packet, std::size_t arm) noexcept {
  const double x = packet.Qx[arm], y = packet.Qy[arm], z = packet.Qz[arm];
  return 2.0 * std::atan2(std::sqrt(x * x + y * y + z * z), std::abs(packet.Qw[arm]));
}

Quat normalised(double x, double y, double z, double w) noexcept {
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(norm > 0.0)) return kIdentityQuat;
  return {x / norm, y / norm, z / norm, w / norm};
}

std::int32_t wordSum(const std::uint8_t* bytes, std::size_t words) noexcept {
  ByteReader in(bytes, words * sizeof(std::uint32_t));
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < words; ++i)
    sum += in.get<std::uint32_t>();
  return static_cast<std::int32_t>(sum);
}

}  // namespace

std::int32_t itpChecksum(const ItpPacket& packet) noexcept {
  std::uint32_t sum = bits(packet.surgeon_mode) + packet.sequence;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    sum += bits(packet.delx_um[arm]) + bits(packet.dely_um[arm]) + bits(packet.delz_um[arm]);
    sum += bits(packet.buttonstate[arm]);
  }
  return static_cast<std::int32_t>(sum);
}

ItpBytes encodeItp(const ItpPacket& packet) noexcept {
  ItpBytes bytes{};
  ByteWriter out(bytes.data(), bytes.size());
  out.put(packet.sequence);
  out.put(packet.pactyp);
  out.put(packet.version);
  for (const auto* pair : {&packet.delx_um, &packet.dely_um, &packet.delz_um})
    putPair(out, *pair);
  for (const auto* pair : {&packet.Qx, &packet.Qy, &packet.Qz, &packet.Qw})
    putPair(out, *pair);
  putPair(out, packet.buttonstate);
  putPair(out, packet.grasp_mrad);
  out.put(packet.surgeon_mode);
  out.put(packet.checksum);
  return bytes;
}

Reject decodeItp(const std::uint8_t* bytes, std::size_t size, ItpPacket* packet) noexcept {
  if (size != kItpSize) return Reject::kWrongSize;
  ByteReader in(bytes, size);
  packet->sequence = in.get<std::uint32_t>();
  packet->pactyp = in.get<std::uint32_t>();
  packet->version = in.get<std::uint32_t>();
  for (auto* pair : {&packet->delx_um, &packet->dely_um, &packet->delz_um})
    getPair(in, pair);
  for (auto* pair : {&packet->Qx, &packet->Qy, &packet->Qz, &packet->Qw})
    getPair(in, pair);
  getPair(in, &packet->buttonstate);
  getPair(in, &packet->grasp_mrad);
  packet->surgeon_mode = in.get<std::int32_t>();
  packet->checksum = in.get<std::int32_t>();
  return Reject::kNone;
}

Reject checkItp(const ItpPacket& packet, const ItpLimits& limits) noexcept {
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    const Reject reason = checkQuaternion(packet.Qx[arm], packet.Qy[arm], packet.Qz[arm], packet.Qw[arm]);
    if (reason != Reject::kNone) return reason;
  }
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    if (!isInRange(packet, arm, limits.max_increment_um)) return Reject::kOutOfRange;
    if (angleOf(packet, arm) > limits.max_rotation) return Reject::kOutOfRange;
  }
  return packet.surgeon_mode == 0 || packet.surgeon_mode == 1 ? Reject::kNone : Reject::kOutOfRange;
}

Reject checkUsable(const ItpPacket& packet) noexcept {
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    const double x = packet.Qx[arm], y = packet.Qy[arm], z = packet.Qz[arm], w = packet.Qw[arm];
    const double norm = std::sqrt(x * x + y * y + z * z + w * w);
    if (!std::isfinite(norm)) return Reject::kNotFinite;
    if (norm < kUsableNorm) return Reject::kBadQuaternion;
  }
  return Reject::kNone;
}

MasterCommand toCommand(const ItpPacket& packet) noexcept {
  MasterCommand command;
  command.sequence = packet.sequence;
  command.pedal = packet.surgeon_mode != 0 ? 1 : 0;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    command.dp_I[arm] = {packet.delx_um[arm] / kMicrometresPerMetre, packet.dely_um[arm] / kMicrometresPerMetre,
                         packet.delz_um[arm] / kMicrometresPerMetre};
    command.dq_I[arm] = normalised(packet.Qx[arm], packet.Qy[arm], packet.Qz[arm], packet.Qw[arm]);
    command.dgrasp[arm] = packet.grasp_mrad[arm] / kMilliPerUnit;
  }
  return command;
}

ItpPacket fromCommand(const MasterCommand& command) noexcept {
  ItpPacket packet;
  packet.sequence = command.sequence;
  packet.surgeon_mode = command.pedal != 0 ? 1 : 0;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    packet.delx_um[arm] = toInt32(command.dp_I[arm][0] * kMicrometresPerMetre);
    packet.dely_um[arm] = toInt32(command.dp_I[arm][1] * kMicrometresPerMetre);
    packet.delz_um[arm] = toInt32(command.dp_I[arm][2] * kMicrometresPerMetre);
    packet.Qx[arm] = command.dq_I[arm][0];
    packet.Qy[arm] = command.dq_I[arm][1];
    packet.Qz[arm] = command.dq_I[arm][2];
    packet.Qw[arm] = command.dq_I[arm][3];
    packet.grasp_mrad[arm] = toInt32(command.dgrasp[arm] * kMilliPerUnit);
  }
  packet.checksum = itpChecksum(packet);
  return packet;
}

ForceBytes encodeForce(const ForcePacket& packet) noexcept {
  ForceBytes bytes{};
  ByteWriter out(bytes.data(), bytes.size());
  out.put(packet.sequence);
  out.put(packet.last_sequence);
  out.put(std::uint32_t{0});  // pactyp
  out.put(std::uint32_t{0});  // version
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t arm = 0; arm < kArmCount; ++arm)
      out.put(toInt32(packet.force_I[arm][axis] * kMilliPerUnit));
  }
  out.put(std::int32_t{packet.runlevel});
  out.put(std::uint32_t{0});  // jointflags
  out.put(wordSum(bytes.data(), kForceWords - 1));
  return bytes;
}

Reject decodeForce(const std::uint8_t* bytes, std::size_t size, ForcePacket* packet) noexcept {
  if (size != kForceSize) return Reject::kWrongSize;
  ByteReader in(bytes, size);
  ForcePacket decoded;
  decoded.sequence = in.get<std::uint32_t>();
  decoded.last_sequence = in.get<std::uint32_t>();
  in.get<std::uint32_t>();  // pactyp
  in.get<std::uint32_t>();  // version
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t arm = 0; arm < kArmCount; ++arm) {
      decoded.force_I[arm][axis] = in.get<std::int32_t>() / kMilliPerUnit;
    }
  }
  const auto runlevel = in.get<std::int32_t>();
  in.get<std::uint32_t>();  // jointflags
  if (in.get<std::int32_t>() != wordSum(bytes, kForceWords - 1)) return Reject::kBadFrame;
  if (runlevel < 0 || runlevel > kMaxRunLevel) return Reject::kOutOfRange;
  decoded.runlevel = static_cast<std::uint8_t>(runlevel);
  *packet = decoded;
  return Reject::kNone;
}

}  // namespace raven2_trainer::wire
