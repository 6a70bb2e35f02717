#include "raven2_trainer/wire/itp_gate.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::wire {
namespace {

constexpr double kUnpinAfter = 0.5;  // [s] a silent master may be replaced by another (sources.md 2.2)
constexpr double kHelloRate = 20.0;  // [1/s] a master asks once a second, at most ten times
constexpr std::int32_t kHelloBurst = 10;

}  // namespace

ItpGate::ItpGate(const ItpRules& rules, Audience audience, const ItpKey* key) noexcept
    : rules_(rules),
      limits_{rules.max_increment_um, rules.max_rotation},
      auth_(key != nullptr ? rules.auth : ItpAuth::kOff),
      unpin_after_ns_(std::llround(std::max(kUnpinAfter, rules.pedalTimeout()) * 1e9)),
      pedal_timeout_ns_(std::llround(rules.pedalTimeout() * 1e9)),
      stream_(audience == Audience::kDaemon ? rules.stream : StreamProfile{}),
      sessions_(key, audience),
      packets_(rules.max_rate, rules.max_burst),
      hellos_(kHelloRate, kHelloBurst),
      signed_only_(auth_ == ItpAuth::kRequired) {}

void ItpGate::allowOnly(std::uint64_t address, std::uint64_t mask) noexcept {
  allowed_ = address;
  allowed_mask_ = mask;
}

Reject ItpGate::judge(const Arrival& arrival, ItpPacket* packet) noexcept {
  if (!isAllowed(arrival.source)) return Reject::kForeignSource;
  return rules_.hardened ? judgeHardened(arrival, packet) : judgeCompat(arrival, packet);
}

/** As a Raven: cut to size, from anyone, its own order. But what is not finite stops here: a model has no watchdog. */
Reject ItpGate::judgeCompat(const Arrival& arrival, ItpPacket* packet) noexcept {
  Reject reason = decodeItp(arrival.bytes, std::min(arrival.size, kItpSize), packet);
  if (reason != Reject::kNone) return reason;
  translate(arrival, packet);
  reason = checkUsable(*packet);
  if (reason != Reject::kNone) return reason;
  reason = compat_rule_.check(packet->sequence);
  last_ = compat_rule_.last();
  if (reason == Reject::kNone) keep(arrival);
  return reason;
}

Reject ItpGate::judgeHardened(const Arrival& arrival, ItpPacket* packet) noexcept {
  if (isForeign(arrival.source)) return Reject::kForeignSource;
  const bool is_signed = auth_ != ItpAuth::kOff && arrival.size == kSignedItpSize;
  const Reject reason = is_signed ? judgeSigned(arrival, packet) : judgePlain(arrival, packet);
  if (reason != Reject::kNone) return reason;
  if (!packets_.take(arrival.time_ns)) return Reject::kRateLimited;
  keep(arrival);
  pin(arrival.source);
  return Reject::kNone;
}

Reject ItpGate::judgePlain(const Arrival& arrival, ItpPacket* packet) noexcept {
  Reject reason = decodeItp(arrival.bytes, arrival.size, packet);
  if (reason != Reject::kNone) return reason;
  if (signed_only_) return Reject::kUnsigned;
  translate(arrival, packet);
  reason = checkItp(*packet, limits_);
  if (reason != Reject::kNone) return reason;
  const bool pedal = packet->surgeon_mode != 0;
  if (!pinned_ && pedal) return Reject::kForeignSource;  // a master introduces itself with the pedal up
  reason = window_.check(packet->sequence, pedal);
  last_ = window_.last();
  if (reason == Reject::kNone) pedal_ = pedal;
  return reason;
}

Reject ItpGate::judgeSigned(const Arrival& arrival, ItpPacket* packet) noexcept {
  Trailer trailer;
  if (!decodeTrailer(arrival.bytes, &trailer)) return Reject::kBadFrame;
  SessionTable::Entry* entry = sessions_.find(trailer.session);
  if (entry == nullptr) return Reject::kOtherSession;
  if (!entry->session.verify(arrival.bytes)) return Reject::kBadSignature;
  if (!entry->window.isFresh(trailer.counter)) return Reject::kReplayed;
  decodeItp(arrival.bytes, kItpSize, packet);
  const Reject reason = checkItp(*packet, limits_);
  if (reason != Reject::kNone) return reason;
  return useSigned(entry, trailer.counter, *packet);
}

/** The sender is proven; is this the time for it? */
Reject ItpGate::useSigned(SessionTable::Entry* entry, std::uint64_t counter, const ItpPacket& packet) noexcept {
  const bool pedal = packet.surgeon_mode != 0;
  if (pedal && !sessions_.isInForce(*entry)) return Reject::kOtherSession;
  if (pedal && !pinned_) return Reject::kForeignSource;
  if (!sessions_.isInForce(*entry)) entry = sessions_.promote(entry);
  signed_only_ = true;
  const bool is_late = entry->window.isLate(counter);
  entry->window.mark(counter);
  if (is_late) return pedal == pedal_ ? Reject::kNone : Reject::kOutOfOrder;
  pedal_ = pedal;
  last_ = packet.sequence;
  return Reject::kNone;
}

/** After a silence in which the pedal counted as up, a console begins again. */
void ItpGate::translate(const Arrival& arrival, ItpPacket* packet) noexcept {
  if (arrival.time_ns - heard_ns_ > pedal_timeout_ns_) stream_.forget();
  stream_.translate(packet);
}

void ItpGate::keep(const Arrival& arrival) noexcept {
  stream_.keep();
  heard_ns_ = arrival.time_ns;
}

bool ItpGate::isAllowed(std::uint64_t source) const noexcept {
  return allowed_mask_ == 0 || (source & allowed_mask_) == allowed_;
}

bool ItpGate::isForeign(std::uint64_t source) const noexcept {
  return !isAllowed(source) || (pinned_ && source != source_);
}

void ItpGate::pin(std::uint64_t source) noexcept {
  pinned_ = true;
  source_ = source;
}

bool ItpGate::isHello(const Arrival& arrival) const noexcept {
  return rules_.hardened && auth_ != ItpAuth::kOff && arrival.size == kHandshakeSize;
}

Reject ItpGate::answer(const Arrival& arrival, const Nonce& fresh, HandshakeBytes* reply) noexcept {
  if (isForeign(arrival.source)) return Reject::kForeignSource;
  Nonce sender;
  const Reject reason = sessions_.examine(arrival.bytes, arrival.size, &sender);
  if (reason != Reject::kNone)
    return reason;  // first: a sender without the key must not use up answers to the one with it
  if (!hellos_.take(arrival.time_ns)) return Reject::kRateLimited;
  sessions_.answer(sender, fresh, reply);
  return Reject::kNone;
}

void ItpGate::idle(std::int64_t now_ns) noexcept {
  if (!pinned_ || now_ns - heard_ns_ <= unpin_after_ns_) return;
  pinned_ = false;
  window_ = SequenceWindow();
  stream_.forget();
}

}  // namespace raven2_trainer::wire
