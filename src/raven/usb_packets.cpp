#include "raven2_trainer/raven/usb_packets.h"

namespace raven2_trainer::raven {
namespace {

constexpr std::uint8_t kTypeIn = 0x03;
constexpr std::uint8_t kTypeOut = 0x06;
constexpr std::int32_t kDacOffset = 0x8000;
constexpr std::size_t kInFirst = 3;
constexpr std::size_t kOutFirst = 2;
constexpr std::size_t kOutPins = 18;

std::uint8_t byteOf(std::uint32_t value, unsigned n) noexcept {
  return static_cast<std::uint8_t>((value >> (8U * n)) & 0xFFU);
}

/** 24-bit two's complement to 32 bits. */
std::int32_t extendSign(std::uint32_t value) noexcept {
  return static_cast<std::int32_t>(value ^ 0x800000U) - 0x800000;
}

}  // namespace

UsbInBytes encodeIn(const UsbIn& packet) noexcept {
  UsbInBytes bytes{};
  bytes[0] = kTypeIn;
  bytes[1] = kChannels;
  bytes[2] = packet.pins;
  for (std::size_t k = 0; k < kChannels; ++k) {
    const auto count = static_cast<std::uint32_t>(packet.encoder[k]);
    for (unsigned n = 0; n < 3; ++n)
      bytes[kInFirst + 3 * k + n] = byteOf(count, n);
  }
  return bytes;
}

UsbOutBytes encodeOut(const UsbOut& packet) noexcept {
  UsbOutBytes bytes{};
  bytes[0] = kTypeOut;
  bytes[1] = kChannels;
  for (std::size_t k = 0; k < kChannels; ++k) {
    const auto code = static_cast<std::uint32_t>(packet.dac[k] + kDacOffset);
    for (unsigned n = 0; n < 2; ++n)
      bytes[kOutFirst + 2 * k + n] = byteOf(code, n);
  }
  bytes[kOutPins] = packet.pins;
  return bytes;
}

bool decodeIn(const UsbInBytes& bytes, UsbIn* packet) noexcept {
  if (bytes[0] != kTypeIn || bytes[1] != kChannels) return false;
  packet->pins = bytes[2];
  for (std::size_t k = 0; k < kChannels; ++k) {
    const std::uint8_t* p = bytes.data() + kInFirst + 3 * k;
    packet->encoder[k] =
        extendSign(p[0] | static_cast<std::uint32_t>(p[1]) << 8U | static_cast<std::uint32_t>(p[2]) << 16U);
  }
  return true;
}

UsbOutBytes startUpWrite() noexcept {
  UsbOut packet;
  packet.dac.fill(static_cast<std::int16_t>(-kDacOffset));
  return encodeOut(packet);
}

bool decodeOut(const UsbOutBytes& bytes, UsbOut* packet) noexcept {
  if (bytes[0] != kTypeOut || bytes[1] != kChannels) return false;
  for (std::size_t k = 0; k < kChannels; ++k) {
    const std::int32_t code = bytes[kOutFirst + 2 * k] | bytes[kOutFirst + 2 * k + 1] << 8;
    packet->dac[k] = static_cast<std::int16_t>(code - kDacOffset);
  }
  packet->pins = bytes[kOutPins];
  return true;
}

}  // namespace raven2_trainer::raven
