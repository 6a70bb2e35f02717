#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/counters.h"

// Packets between the Raven's control software and its two USB boards (raven2.md 4.6). Eight channels a board: 0..2
// positioning joints, 3 not connected, 4..7 tool joints.

namespace raven2_trainer::raven {

constexpr std::size_t kChannels = 8;

/** IN: board to software, 27 bytes. */
struct UsbIn {
  std::uint8_t pins{};                            ///< PLC state in bits 6 and 7
  std::array<std::int32_t, kChannels> encoder{};  ///< [counts] 24-bit, as the board counts (the software negates)
};
/** OUT: software to board, 19 bytes. */
struct UsbOut {
  std::array<std::int16_t, kChannels> dac{};  ///< [counts]
  std::uint8_t pins{};                        ///< run level echo, FP, READY, watchdog
};

using UsbInBytes = std::array<std::uint8_t, 27>;
using UsbOutBytes = std::array<std::uint8_t, 19>;

UsbInBytes encodeIn(const UsbIn& packet) noexcept;
UsbOutBytes encodeOut(const UsbOut& packet) noexcept;
/** false, `*packet` unchanged, unless type byte and channel count are right. */
bool decodeIn(const UsbInBytes& bytes, UsbIn* packet) noexcept;
bool decodeOut(const UsbOutBytes& bytes, UsbOut* packet) noexcept;

}  // namespace raven2_trainer::raven
