#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/faults/packet_stream.h"
#include "raven2_trainer/wire/itp.h"

// Fault site network_layer on ITP packets of the wire: for the virtual Raven, and for a program
// between a real one and its socket. Real-time safe.

namespace raven2_trainer::raven {

/** Access to a packet for faults on a stream. */
struct ItpTraits {
  static std::uint32_t& sequence(wire::ItpPacket& packet) noexcept { return packet.sequence; }
  static void takeMotion(wire::ItpPacket* to, const wire::ItpPacket& from) noexcept;
  static void forge(wire::ItpPacket* packet, Arm arm, std::size_t axis, double um) noexcept;
};
using ItpStream = faults::PacketStream<wire::ItpPacket, ItpTraits>;

/** Faults on the fields of one packet, before any check (paper, Table 1). The checksum stays: nobody demands it. */
void injectFaults(faults::FaultEngine* faults, wire::ItpPacket* packet) noexcept;

}  // namespace raven2_trainer::raven
