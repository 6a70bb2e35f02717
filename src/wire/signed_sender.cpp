#include "raven2_trainer/wire/signed_sender.h"

#include <algorithm>

namespace raven2_trainer::wire {
namespace {

constexpr std::int64_t kFirstPauseNs = 100'000'000;  // doubles up to:
constexpr std::int64_t kPauseNs = 1'000'000'000;     // a Raven that cannot answer logs each one

}  // namespace

HandshakeBytes SignedSender::hello(const Nonce& fresh, std::int64_t now_ns) noexcept {
  nonce_ = fresh;
  asked_ = true;
  pause_ns_ = std::clamp(2 * pause_ns_, kFirstPauseNs, kPauseNs);
  due_ns_ = now_ns + pause_ns_;
  return encodeHello(key_, audience_, nonce_);
}

bool SignedSender::receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns) noexcept {
  Nonce receiver;
  if (!asked_ || decodeChallenge(key_, audience_, nonce_, bytes, size, &receiver) != Reject::kNone) return false;
  asked_ = false;
  next_ = ItpSession(key_, audience_, nonce_, receiver);
  pause_ns_ = 0;  // quick again when one is not answered
  due_ns_ = now_ns + kPauseNs;
  return true;
}

SignedItpBytes SignedSender::sign(const ItpBytes& itp, bool pedal) noexcept {
  if (next_.isOpen() && (!pedal || !current_.isOpen())) {
    current_ = next_;
    next_ = ItpSession();
    counter_ = 0;
  }
  return current_.sign(itp, ++counter_);
}

}  // namespace raven2_trainer::wire
