#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/bytes.h"
#include "raven2_trainer/core/counters.h"

// Frame of this package's own datagrams: magic u32, version u16, size u16, the body, then the CRC-32
// (zlib's) of all before it.

namespace raven2_trainer::wire {

struct PacketKind {
  std::uint32_t magic{};
  std::uint16_t version{};
  std::uint16_t size{};  ///< [bytes] of the whole
};

/** Norms of a quaternion that a packet may have (sources.md 2.2). */
constexpr double kQuaternionNormMin = 0.98, kQuaternionNormMax = 1.02;

constexpr std::size_t kPacketHead = 8;  ///< [bytes]
constexpr std::size_t kPacketTail = sizeof(std::uint32_t);

inline void putHead(ByteWriter& out, const PacketKind& kind) noexcept {
  out.put(kind.magic);
  out.put(kind.version);
  out.put(kind.size);
}

inline std::uint32_t packetCrc(const std::uint8_t* bytes, std::size_t size) noexcept {
  return static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(size - kPacketTail)));
}

/** Size, magic, CRC, version, length, in this order: kNone, kWrongSize, kBadFrame or kBadVersion. */
inline Reject checkPacket(const std::uint8_t* bytes, std::size_t size, const PacketKind& kind) noexcept {
  if (size != kind.size) return Reject::kWrongSize;
  ByteReader head(bytes, kPacketHead), tail(bytes + size - kPacketTail, kPacketTail);
  if (head.get<std::uint32_t>() != kind.magic) return Reject::kBadFrame;
  if (tail.get<std::uint32_t>() != packetCrc(bytes, size)) return Reject::kBadFrame;
  if (head.get<std::uint16_t>() != kind.version) return Reject::kBadVersion;
  return head.get<std::uint16_t>() == kind.size ? Reject::kNone : Reject::kBadFrame;
}

}  // namespace raven2_trainer::wire
