#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/sight.h"

// View of a simulated surgeon, in place of a picture: poses of tools, bodies and camera. Described byte for byte in
// doc/wire.md.

namespace raven2_trainer::wire {

constexpr std::uint32_t kSightMagic = 0x45325652;  ///< "RV2E" in memory
constexpr std::uint16_t kSightVersion = 1;
constexpr std::size_t kSightSize = 908;

using SightBytes = std::array<std::uint8_t, kSightSize>;

/** Encodes as is. */
SightBytes encodeSight(const Sight& sight) noexcept;

/** kWrongSize, kBadFrame (magic, CRC, length), kBadVersion, kNotFinite, kBadQuaternion (norm not 0.98 to 1.02) or
 *  kOutOfRange (a mode, run level, flag, place or opening that cannot be), `*sight` unchanged, unless kNone. */
Reject decodeSight(const std::uint8_t* bytes, std::size_t size, Sight* sight) noexcept;

}  // namespace raven2_trainer::wire
