#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/counters.h"

// Interoperable Telerobotics Protocol: bytes to structs and back. Layouts and meaning: raven2.md 1.1 to 1.3.

namespace raven2_trainer::wire {

constexpr std::size_t kItpSize = 124;   ///< u_struct, packed
constexpr std::size_t kForceSize = 52;  ///< v_struct, packed

/** u_struct, master to robot, with the names and units of the wire. Index 0 is gold. */
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

/** The sum the robot's software defines and never checks: fill it, do not demand it (raven2.md 1.3). */
std::int32_t itpChecksum(const ItpPacket& packet) noexcept;

/** Encodes as is; the checksum field is taken from the packet. */
ItpBytes encodeItp(const ItpPacket& packet) noexcept;

/** Copies the fields of exactly kItpSize bytes; no value is judged. kWrongSize, `*packet` unchanged, otherwise. */
Reject decodeItp(const std::uint8_t* bytes, std::size_t size, ItpPacket* packet) noexcept;

/** Limits of an honest packet. */
struct ItpLimits {
  std::int32_t max_increment_um{};  ///< [um] each axis
  double max_rotation{kPi};         ///< [rad]
};

/**
 * Judges the values: finite quaternions of norm 0.98 to 1.02, increments and rotations within the limits, grasp
 * increments within the whole range of the jaws (1745 mrad), surgeon_mode 0 or 1.
 * @return kNone, kNotFinite, kBadQuaternion or kOutOfRange.
 */
Reject checkItp(const ItpPacket& packet, const ItpLimits& limits) noexcept;

/** Only what no model survives: kNotFinite, or kBadQuaternion for one that cannot be made a unit one. */
Reject checkUsable(const ItpPacket& packet) noexcept;

/** To SI units; quaternions are renormalised. Grasp: positive closes, on the wire and here (raven2.md 1.4). */
MasterCommand toCommand(const ItpPacket& packet) noexcept;

/** From SI units, with the checksum filled in. Increments are rounded to the micrometre and milliradian: a caller that
 *  sends a stream of them carries the remainder. */
ItpPacket fromCommand(const MasterCommand& command) noexcept;

using ForceBytes = std::array<std::uint8_t, kForceSize>;

/** v_struct: forces in millinewtons along the master's axes (decisions: UDP 36001). */
ForceBytes encodeForce(const ForcePacket& packet) noexcept;

/** kWrongSize, kBadFrame (checksum: sum of the words before it) or kOutOfRange (run level), `*packet` unchanged, unless
 *  kNone. */
Reject decodeForce(const std::uint8_t* bytes, std::size_t size, ForcePacket* packet) noexcept;

}  // namespace raven2_trainer::wire
