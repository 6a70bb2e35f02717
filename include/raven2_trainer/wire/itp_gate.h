#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/wire/itp.h"
#include "raven2_trainer/wire/itp_rules.h"
#include "raven2_trainer/wire/sequence_rule.h"
#include "raven2_trainer/wire/sequence_window.h"
#include "raven2_trainer/wire/session_table.h"
#include "raven2_trainer/wire/stream_translator.h"
#include "raven2_trainer/wire/token_bucket.h"

namespace raven2_trainer::wire {

/** A datagram as it arrived. */
struct Arrival {
  const std::uint8_t* bytes{};
  std::size_t size{};      ///< true size, also of one cut by a short buffer
  std::uint64_t source{};  ///< names address and port; compared only
  std::int64_t time_ns{};  ///< [ns] receiver's own clock, never back
};

/**
 * Checks a received ITP datagram: size, source, signature, values, order, rate, in this order. Each reason
 * of rejection is one of core's Reject. `compat`: a Raven's own rules, from anyone. `hardened`: one pinned master, and
 * with a key only signed packets. For the daemon alone, a console's own variant of ITP is translated first.
 * Knows no socket and no clock. Real-time safe. Rules: doc/wire.md.
 */
class ItpGate {
 public:
  /** @param[in] key of signed ITP, outlives this; nullptr: nothing is verified, whatever `rules` say. */
  ItpGate(const ItpRules& rules, Audience audience, const ItpKey* key) noexcept;

  /** Only sources whose bits under `mask` are those of `address` are heard; mask 0: anyone. */
  void allowOnly(std::uint64_t address, std::uint64_t mask) noexcept;

  bool isAllowed(std::uint64_t source) const noexcept;

  /** One ITP datagram. @return kNone: use `*packet`. */
  Reject judge(const Arrival& arrival, ItpPacket* packet) noexcept;

  /** Whether this asks for a session, if anybody is to be answered; then it is answer()'s, not judge()'s. */
  bool isHello(const Arrival& arrival) const noexcept;
  /** @param[in] fresh random, used at most once. @return kNone: send `*reply` back to the source. */
  Reject answer(const Arrival& arrival, const Nonce& fresh, HandshakeBytes* reply) noexcept;

  /** Lets go of a master that has been silent, once its pedal counts as up. Call at least every 100 ms. */
  void idle(std::int64_t now_ns) noexcept;

  /** Whether a packet without a signature could be used: no key asked for, and none of this master's was signed yet. */
  bool takesUnsigned() const noexcept { return !signed_only_; }
  bool isPinned() const noexcept { return pinned_; }
  std::uint64_t source() const noexcept { return source_; }  ///< of the pinned master
  /** Newest number taken as the last one. */
  std::uint32_t last() const noexcept { return last_; }

 private:
  Reject judgeCompat(const Arrival& arrival, ItpPacket* packet) noexcept;
  Reject judgeHardened(const Arrival& arrival, ItpPacket* packet) noexcept;
  Reject judgePlain(const Arrival& arrival, ItpPacket* packet) noexcept;
  Reject judgeSigned(const Arrival& arrival, ItpPacket* packet) noexcept;
  Reject useSigned(SessionTable::Entry* entry, std::uint64_t counter, const ItpPacket& packet) noexcept;
  bool isForeign(std::uint64_t source) const noexcept;
  void translate(const Arrival& arrival, ItpPacket* packet) noexcept;
  void keep(const Arrival& arrival) noexcept;
  void pin(std::uint64_t source) noexcept;

  ItpRules rules_;
  ItpLimits limits_;
  ItpAuth auth_;
  std::int64_t unpin_after_ns_, pedal_timeout_ns_;
  std::uint64_t allowed_{0}, allowed_mask_{0};

  StreamTranslator stream_;
  SequenceRule compat_rule_;
  SequenceWindow window_;
  SessionTable sessions_;
  TokenBucket packets_, hellos_;
  bool signed_only_;  ///< plain ones are refused from now on
  bool pinned_{false};
  bool pedal_{false};  ///< of the newest packet
  std::uint64_t source_{0};
  std::int64_t heard_ns_{0};  ///< last packet that was used
  std::uint32_t last_{0};
};

}  // namespace raven2_trainer::wire
