#include "raven2_trainer/wire/sight.h"

#include <cmath>

#include "raven2_trainer/core/bytes.h"
#include "sealed_packet.h"

namespace raven2_trainer::wire {
namespace {

constexpr PacketKind kSightKind{kSightMagic, kSightVersion, kSightSize};

constexpr std::size_t kPoses = kArmCount + kMaxSceneBodies;
static_assert(kPacketHead + 4 + 8 + 4 + 2 + 1 + 1 + 4 + (kPoses * 7 + kArmCount + 9) * sizeof(double) + kPacketTail ==
                  kSightSize,
              "the layout of doc/wire.md; another size needs another version");

constexpr double kMaxPlace = 1e6;  ///< [m] a body that fell off the scene for minutes is nearer
/** Every number of a sight in the order of the wire, array by array. */
template <typename Seen, typename Call>
void forEachArray(Seen& sight, Call call) noexcept {
  for (auto& pose : sight.tool_W) {
    call(pose.p);
    call(pose.q);
  }
  call(sight.opening);
  for (auto& pose : sight.bodies_W) {
    call(pose.p);
    call(pose.q);
  }
  call(sight.camera.eye_W);
  call(sight.camera.target_W);
  call(sight.camera.up_W);
}

template <typename Array>
bool areWithin(const Array& values, double limit) noexcept {
  for (const double value : values) {
    if (std::abs(value) > limit) return false;
  }
  return true;
}

Reject checkPose(const RigidPose& pose) noexcept {
  double squares = 0.0;
  for (const double x : pose.q)
    squares += x * x;
  const double norm = std::sqrt(squares);
  if (norm < kQuaternionNormMin || norm > kQuaternionNormMax) return Reject::kBadQuaternion;
  return areWithin(pose.p, kMaxPlace) ? Reject::kNone : Reject::kOutOfRange;
}

Reject checkNumbers(const Sight& sight) noexcept {
  bool is_finite = true;
  forEachArray(sight, [&is_finite](const auto& values) {
    for (const double value : values)
      is_finite = is_finite && std::isfinite(value);
  });
  if (!is_finite) return Reject::kNotFinite;
  for (const RigidPose& pose : sight.tool_W) {
    if (const Reject reason = checkPose(pose); reason != Reject::kNone) return reason;
  }
  for (const RigidPose& pose : sight.bodies_W) {
    if (const Reject reason = checkPose(pose); reason != Reject::kNone) return reason;
  }
  const CameraState& camera = sight.camera;
  const bool is_placed =
      areWithin(camera.eye_W, kMaxPlace) && areWithin(camera.target_W, kMaxPlace) && areWithin(camera.up_W, kMaxPlace);
  return is_placed && areWithin(sight.opening, 2.0 * kPi) ? Reject::kNone : Reject::kOutOfRange;
}

/** Mode, run level and flags. @return false on a value they cannot have. */
bool getStatus(ByteReader& in, Sight* sight) noexcept {
  sight->tick = in.get<Tick>();
  const auto mode = in.get<std::uint8_t>();
  const auto runlevel = in.get<std::uint8_t>();
  sight->linked = in.get<std::uint8_t>();
  const auto exercise = in.get<std::uint8_t>();
  sight->broken = in.get<std::uint16_t>();
  sight->ghost = in.get<std::uint8_t>();
  const auto reserved = in.get<std::uint8_t>();
  sight->step = in.get<std::uint32_t>();
  if (mode >= kModeCount || runlevel >= kRunLevelNames.size() || exercise >= kExerciseStatusCount) return false;
  sight->mode = static_cast<Mode>(mode);
  sight->runlevel = static_cast<RunLevel>(runlevel);
  sight->exercise = static_cast<ExerciseStatus>(exercise);
  return sight->tick >= 0 && sight->linked <= 1 && reserved == 0 && sight->ghost >> kArmCount == 0 &&
         sight->broken >> kMaxSceneBodies == 0;
}

}  // namespace

SightBytes encodeSight(const Sight& sight) noexcept {
  SightBytes bytes{};
  ByteWriter out(bytes.data(), bytes.size());
  putHead(out, kSightKind);
  out.put(sight.sequence);
  out.put(sight.tick);
  out.put(static_cast<std::uint8_t>(sight.mode));
  out.put(static_cast<std::uint8_t>(sight.runlevel));
  out.put(sight.linked);
  out.put(static_cast<std::uint8_t>(sight.exercise));
  out.put(sight.broken);
  out.put(sight.ghost);
  out.put(std::uint8_t{0});
  out.put(sight.step);
  forEachArray(sight, [&out](const auto& values) { putAll(out, values); });
  out.put(packetCrc(bytes.data(), bytes.size()));
  return bytes;
}

Reject decodeSight(const std::uint8_t* bytes, std::size_t size, Sight* sight) noexcept {
  const Reject reason = checkPacket(bytes, size, kSightKind);
  if (reason != Reject::kNone) return reason;
  ByteReader in(bytes + kPacketHead, size - kPacketHead);
  Sight decoded;
  decoded.sequence = in.get<std::uint32_t>();
  if (!getStatus(in, &decoded)) return Reject::kOutOfRange;
  forEachArray(decoded, [&in](auto& values) { getAll(in, &values); });
  const Reject wrong = checkNumbers(decoded);
  if (wrong != Reject::kNone) return wrong;
  *sight = decoded;
  return Reject::kNone;
}

}  // namespace raven2_trainer::wire
