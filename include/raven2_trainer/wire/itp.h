#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/counters.h"

// Encodes and decodes the Interoperable Telerobotics Protocol (ITP). Layouts and meaning: doc/raven2.md 1.1 to 1.3.

namespace raven2_trainer::wire {

constexpr std::size_t kItpSize = 124;   ///< [bytes] u_struct, packed
constexpr std::size_t kForceSize = 52;  ///< [bytes] v_struct, packed

/** u_struct, from master to robot, with its original names and units. Index 0 is gold. */
struct ItpPacket {
  std::uint32_t sequence{};
  std::uint32_t pactyp{};
  std::uint32_t version{};
  PerArm<std::int32_t> delx_um{}, dely_um{}, delz_um{};
  PerArm<double> Qx{}, Qy{}, Qz{}, Qw{{1.0, 1.0}};
  PerArm<std::int32_t> buttonstate{};
  PerArm<std::int32_t> grasp_mrad{};
  std::int32_t surgeon_mode{};
  std::int32_t checksum{};
};

using ItpBytes = std::array<std::uint8_t, kItpSize>;

/** The robot's software defines this checksum but never checks it: send it, do not require it (raven2.md 1.3). */
std::int32_t itpChecksum(const ItpPacket& packet) noexcept;

/** Encodes all fields unchanged, including the checksum. */
ItpBytes encodeItp(const ItpPacket& packet) noexcept;

/** Decodes kItpSize bytes; checks no value. @return kWrongSize, with `*packet` unchanged, for another size. */
Reject decodeItp(const std::uint8_t* bytes, std::size_t size, ItpPacket* packet) noexcept;

/** Limits of a plausible packet. */
struct ItpLimits {
  std::int32_t max_increment_um{};  ///< [um] per axis
  double max_rotation{kPi};         ///< [rad]
};

/**
 * Checks the values: finite quaternions of norm 0.98 to 1.02, increments and rotations within `limits`, grasp
 * increments within the jaws' whole range (1745 mrad), surgeon_mode 0 or 1.
 * @return kNone, kNotFinite, kBadQuaternion or kOutOfRange.
 */
Reject checkItp(const ItpPacket& packet, const ItpLimits& limits) noexcept;

/** Checks only for unusable quaternions. @return kNone, kNotFinite, or kBadQuaternion for a norm near zero. */
Reject checkUsable(const ItpPacket& packet) noexcept;

/** Converts to SI units and normalises quaternions. Positive grasp closes, in packet and command (raven2.md 1.4). */
MasterCommand toCommand(const ItpPacket& packet) noexcept;

/** Converts from SI units and sets the checksum. Rounds increments to micrometres and milliradians: in a stream, the
 *  caller must add the remainder to the next command. */
ItpPacket fromCommand(const MasterCommand& command) noexcept;

using ForceBytes = std::array<std::uint8_t, kForceSize>;

/** Encodes v_struct: forces in millinewtons along the master's axes (raven2.md 1.2). */
ForceBytes encodeForce(const ForcePacket& packet) noexcept;

/** Decodes v_struct. @return kNone; else, with `*packet` unchanged, kWrongSize, kBadFrame (checksum is not the sum of
 * the words before it) or kOutOfRange (run level). */
Reject decodeForce(const std::uint8_t* bytes, std::size_t size, ForcePacket* packet) noexcept;

}  // namespace raven2_trainer::wire
