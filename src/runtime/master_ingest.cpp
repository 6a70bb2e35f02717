#include "raven2_trainer/runtime/master_ingest.h"

#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::runtime {

Reject MasterIngest::receive(const std::uint8_t* bytes, std::size_t size, bool foreign) noexcept {
  const Reject reason = judge(bytes, size, foreign);
  counts_.count(reason);
  shared_.master_link.store(counts_);
  return reason;
}

Reject MasterIngest::judge(const std::uint8_t* bytes, std::size_t size, bool foreign) noexcept {
  if (foreign) return Reject::kForeignSource;
  wire::ItpPacket packet;
  Reject reason = wire::decodeItp(bytes, size, &packet);
  if (reason != Reject::kNone) return reason;
  reason = wire::checkItp(packet, max_increment_um_);
  if (reason != Reject::kNone) return reason;
  reason = window_.check(packet.sequence, packet.surgeon_mode != 0);
  if (reason != Reject::kNone) return reason;
  return shared_.master_commands.tryPush(wire::toCommand(packet)) ? Reject::kNone : Reject::kQueueFull;
}

}  // namespace raven2_trainer::runtime
