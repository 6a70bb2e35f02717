#include "raven2_trainer/loop/master_ingest.h"

#include "raven2_trainer/wire/pedals.h"

namespace raven2_trainer::loop {

Reject MasterIngest::receive(const wire::Arrival& arrival) noexcept {
  return wire::isPedals(arrival.bytes, arrival.size) ? takePedals(arrival) : count(judge(arrival));
}

void MasterIngest::idle(std::int64_t now_ns) noexcept {
  gate_.idle(now_ns);
  if (watch_.look(counts_, now_ns)) shared_.master_stream.store(watch_.finding());
  ask(pedal_gate_.idle(now_ns));
}

Reject MasterIngest::takePedals(const wire::Arrival& arrival) noexcept {
  PedalState pedals;
  const Reject reason = judgePedals(arrival, &pedals);
  pedal_counts_.count(reason);
  shared_.pedal_link.store(pedal_counts_);
  if (reason != Reject::kNone) return reason;
  shared_.model.tryLoad(&model_);  // lapped: a tick older is as good
  ask(pedal_gate_.take(pedals, arrival.time_ns, model_.mode, model_.view));
  return reason;
}

Reject MasterIngest::judgePedals(const wire::Arrival& arrival, PedalState* pedals) noexcept {
  if (!gate_.isAllowed(arrival.source)) return Reject::kForeignSource;
  if (rules_.auth == ItpAuth::kRequired || !gate_.takesUnsigned()) return Reject::kUnsigned;
  if (rules_.hardened && (!gate_.isPinned() || arrival.source != gate_.source())) return Reject::kForeignSource;
  Reject reason = wire::decodePedals(arrival.bytes, arrival.size, pedals);
  if (reason == Reject::kNone) reason = pedal_gate_.check(pedals->sequence, arrival.time_ns);
  if (reason == Reject::kNone && !pedal_rate_.take(arrival.time_ns)) reason = Reject::kRateLimited;
  return reason;
}

/** A request that finds its ring full is counted there. The next press sends it again. */
void MasterIngest::ask(const PedalRequests& requests) noexcept {
  for (std::size_t i = 0; i < requests.count; ++i)
    shared_.pedal_requests.tryPush(requests.items[i]);
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
  if (!shared_.master_commands.tryPush(wire::toCommand(packet))) return Reject::kQueueFull;
  return Reject::kNone;
}

Reject MasterIngest::count(Reject reason) noexcept {
  counts_.count(reason);
  shared_.master_link.store(counts_);
  return reason;
}

}  // namespace raven2_trainer::loop
