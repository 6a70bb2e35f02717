#pragma once

#include <sys/types.h>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/raven/usb_packets.h"
#include "raven2_trainer/wire/itp.h"

// The wrapped calls use this: descriptors of the boards and of the socket, the decision whether
// anything is injected, taken once, and the faults. Nothing here throws, and only decide() allocates or locks.

namespace raven2_trainer::preload {

/** Use of a descriptor. */
enum class Role : std::uint8_t { kUnknown, kOther, kGold, kGreen, kItp };

constexpr bool isBoard(Role role) noexcept {
  return role == Role::kGold || role == Role::kGreen;
}
constexpr Arm armOf(Role role) noexcept {
  return role == Role::kGreen ? Arm::kGreen : Arm::kGold;
}

Role roleOf(int descriptor) noexcept;
/** The socket of ITP is known by its port, asked for with the first packet. */
Role roleOfSocket(int descriptor) noexcept;

/** A file was opened: is it a board's? With the first, or the first packet, the keys and the scenario are looked at. */
void opened(const char* path, int descriptor) noexcept;
void closed(int descriptor) noexcept;

/** Whether anything may be injected. */
bool isOn() noexcept;

/** A board's read has returned `count`, errno as the call left it. @return what the program is to get, errno set. */
ssize_t afterRead(Arm arm, ssize_t count, void* buffer, std::size_t size) noexcept;

/** Where a board's packet goes. */
struct Delivery {
  int descriptor{-1};  ///< -1: nowhere, and the program gets the answer that it was written
  raven::UsbOutBytes bytes{};
};
/** The program writes a packet to `descriptor`, which is this arm's board. */
Delivery beforeWrite(Arm arm, int descriptor, const void* buffer) noexcept;

void offerPacket(const void* buffer) noexcept;
/** @return false if the program is to get none now. */
bool takePacket(wire::ItpBytes* bytes) noexcept;

}  // namespace raven2_trainer::preload
