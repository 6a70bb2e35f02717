#include "raven2_trainer/wire/pedals.h"

#include "raven2_trainer/core/bytes.h"
#include "sealed_packet.h"

namespace raven2_trainer::wire {
namespace {

constexpr PacketKind kPedalKind{kPedalMagic, kPedalVersion, kPedalSize};
constexpr std::uint32_t kKnown = (1U << kPedalCount) - 1U;

}  // namespace

PedalBytes encodePedals(const PedalState& pedals) noexcept {
  PedalBytes bytes{};
  ByteWriter out(bytes.data(), bytes.size());
  putHead(out, kPedalKind);
  out.put(pedals.sequence);
  out.put(pedals.held);
  out.put(std::uint32_t{0});
  out.put(packetCrc(bytes.data(), bytes.size()));
  return bytes;
}

bool isPedals(const std::uint8_t* bytes, std::size_t size) noexcept {
  return size == kPedalSize && ByteReader(bytes, size).get<std::uint32_t>() == kPedalMagic;
}

Reject decodePedals(const std::uint8_t* bytes, std::size_t size, PedalState* pedals) noexcept {
  const Reject reason = checkPacket(bytes, size, kPedalKind);
  if (reason != Reject::kNone) return reason;
  ByteReader in(bytes + kPacketHead, size - kPacketHead);
  PedalState decoded;
  decoded.sequence = in.get<std::uint32_t>();
  decoded.held = in.get<std::uint32_t>();
  if ((decoded.held & ~kKnown) != 0 || in.get<std::uint32_t>() != 0) return Reject::kOutOfRange;
  *pedals = decoded;
  return Reject::kNone;
}

}  // namespace raven2_trainer::wire
