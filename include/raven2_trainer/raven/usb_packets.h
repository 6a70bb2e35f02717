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
/** What read() on a board's device file gave (raven2.md 4.6): 27 and the bytes, or a negative error number. */
struct UsbRead {
  static constexpr std::int32_t kComplete = 27;
  static constexpr std::int32_t kBusy = -16;      ///< -EBUSY: the packet is still pending
  static constexpr std::int32_t kNoDevice = -19;  ///< -ENODEV: nobody started a read

  std::int32_t result{kComplete};  ///< [bytes] or error; anything but 27 leaves the old counts and pins
  std::array<std::uint8_t, 27> bytes{};
};
/** OUT: software to board, 19 bytes. */
struct UsbOut {
  std::array<std::int16_t, kChannels> dac{};  ///< [counts]
  std::uint8_t pins{};                        ///< run level echo, FP, READY, watchdog
};

/** What 16 bits of a wider command say, as the boards get them (raven2 put_USB_packet.cpp:76-99). */
constexpr std::int16_t low16(std::int32_t command) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(static_cast<std::uint32_t>(command)));
}

/** 24-bit counts. */
constexpr std::int32_t clampCount(std::int32_t count) noexcept {
  return count < -8388608 ? -8388608 : count > 8388607 ? 8388607 : count;
}

using UsbInBytes = std::array<std::uint8_t, 27>;
using UsbOutBytes = std::array<std::uint8_t, 19>;

UsbInBytes encodeIn(const UsbIn& packet) noexcept;
UsbOutBytes encodeOut(const UsbOut& packet) noexcept;
/** false, `*packet` unchanged, unless type byte and channel count are right. */
bool decodeIn(const UsbInBytes& bytes, UsbIn* packet) noexcept;
bool decodeOut(const UsbOutBytes& bytes, UsbOut* packet) noexcept;

/** The write of the original's start-up, before its first cycle: 0x0000, full negative scale, on all channels, pins 0
 *  (raven2 USB_init.cpp:114-124). A board must ignore it in E-STOP. */
UsbOutBytes startUpWrite() noexcept;

}  // namespace raven2_trainer::raven
