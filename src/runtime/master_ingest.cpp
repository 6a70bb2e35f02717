#include "raven2_trainer/runtime/master_ingest.h"

namespace raven2_trainer::runtime {

Reject MasterIngest::receive(const wire::Arrival& arrival) noexcept {
  return count(judge(arrival));
}

Reject MasterIngest::answer(const wire::Arrival& arrival,
                            const wire::Nonce& fresh,
                            wire::HandshakeBytes* reply) noexcept {
  const Reject reason = gate_.answer(arrival, fresh, reply);
  return reason == Reject::kNone ? reason : count(reason);
}

Reject MasterIngest::judge(const wire::Arrival& arrival) noexcept {
  wire::ItpPacket packet;
  const Reject reason = gate_.judge(arrival, &packet);
  if (reason != Reject::kNone) return reason;
  return shared_.master_commands.tryPush(wire::toCommand(packet)) ? Reject::kNone : Reject::kQueueFull;
}

Reject MasterIngest::count(Reject reason) noexcept {
  counts_.count(reason);
  shared_.master_link.store(counts_);
  return reason;
}

}  // namespace raven2_trainer::runtime
