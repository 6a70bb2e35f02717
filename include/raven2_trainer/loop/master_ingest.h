#pragma once

#include <cstdint>

#include "raven2_trainer/loop/pedal_gate.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/wire/itp_gate.h"
#include "raven2_trainer/wire/itp_rules.h"
#include "raven2_trainer/wire/stream_watch.h"
#include "raven2_trainer/wire/token_bucket.h"

namespace raven2_trainer::loop {

/**
 * Body of the ingest thread: checks, counts and queues each datagram. Pedal packets are accepted only from the sender
 * of ITP, and counted separately. They are unsigned, so they are rejected where ITP must be signed. Real-time safe.
 */
class MasterIngest {
 public:
  /** @param[in] key of signed ITP, outlives this; nullptr: no verification. */
  MasterIngest(const ItpRules& rules, const wire::ItpKey* key, SharedState* shared) noexcept
      : rules_(rules),
        gate_(rules, wire::Audience::kDaemon, key),
        pedal_gate_(rules.pedalTimeout()),
        shared_(*shared) {}

  /** Accepts packets only from this address (address << 16). */
  void allowOnly(std::uint64_t address) noexcept { gate_.allowOnly(address, kAddressBits); }

  /** Processes a datagram; its size is the true one even if longer than the buffer. */
  Reject receive(const wire::Arrival& arrival) noexcept;

  /** Whether a datagram begins a signed-ITP handshake; then call answer(), not receive(). */
  bool isHello(const wire::Arrival& arrival) const noexcept { return gate_.isHello(arrival); }
  /** @param[in] fresh random, used at most once. @return kNone (uncounted): send `*reply` to the source. */
  Reject answer(const wire::Arrival& arrival, const wire::Nonce& fresh, wire::HandshakeBytes* reply) noexcept;

  /** Unpins a silent master. Reports a stream of mostly rejected packets. Call at least every 100 ms. */
  void idle(std::int64_t now_ns) noexcept;

  bool isPinned() const noexcept { return gate_.isPinned(); }
  std::uint64_t source() const noexcept { return gate_.source(); }  ///< of the pinned master
  const LinkCounts& counts() const noexcept { return counts_; }
  /** Counts of pedal packets. */
  const LinkCounts& pedalCounts() const noexcept { return pedal_counts_; }

 private:
  static constexpr double kPedalRate = 200.0;      ///< [1/s] twice PedalBeat's
  static constexpr std::int32_t kPedalBurst = 50;  ///< a quarter of a second that arrives at once, and edges
  static constexpr std::uint64_t kAddressBits = 0xFFFFFFFFULL << 16U;

  Reject judge(const wire::Arrival& arrival) noexcept;
  Reject count(Reject reason) noexcept;
  Reject takePedals(const wire::Arrival& arrival) noexcept;
  Reject judgePedals(const wire::Arrival& arrival, PedalState* pedals) noexcept;
  void ask(const PedalRequests& requests) noexcept;

  ItpRules rules_;
  wire::ItpGate gate_;
  PedalGate pedal_gate_;
  wire::TokenBucket pedal_rate_{kPedalRate, kPedalBurst};
  SharedState& shared_;
  ModelState model_{};  ///< as last read
  LinkCounts counts_{}, pedal_counts_{};
  wire::StreamWatch watch_;
};

}  // namespace raven2_trainer::loop
