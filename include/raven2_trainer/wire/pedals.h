#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/pedals.h"

// Pedals and buttons that ITP has no room for: a separate packet to the same port. Each packet has all
// held pedals, so the next one makes up a lost one. Described byte for byte in doc/wire.md.

namespace raven2_trainer::wire {

constexpr std::uint32_t kPedalMagic = 0x50325652;  ///< "RV2P" in memory
constexpr std::uint16_t kPedalVersion = 1;
constexpr std::size_t kPedalSize = 24;

using PedalBytes = std::array<std::uint8_t, kPedalSize>;

/** Encodes as is. */
PedalBytes encodePedals(const PedalState& pedals) noexcept;

/** Is it meant as one? By size and magic, which no ITP packet has. */
bool isPedals(const std::uint8_t* bytes, std::size_t size) noexcept;

/** kWrongSize, kBadFrame (magic, CRC, length), kBadVersion or kOutOfRange (pedals that there are not), `*pedals`
 *  unchanged, unless kNone. */
Reject decodePedals(const std::uint8_t* bytes, std::size_t size, PedalState* pedals) noexcept;

}  // namespace raven2_trainer::wire
