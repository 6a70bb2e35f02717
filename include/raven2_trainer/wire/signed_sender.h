#pragma once

#include <cstdint>

#include "raven2_trainer/wire/itp_session.h"

namespace raven2_trainer::wire {

/**
 * The sender's side of signed ITP: asks for a session until it has one, and once a second for the next one, so that a
 * receiver started again is found again. A new session is used from the first packet with the pedal up on, because a
 * receiver takes over none with the pedal down. Knows no socket and no clock. Real-time safe.
 */
class SignedSender {
 public:
  /** `key` outlives this. */
  SignedSender(const ItpKey* key, Audience audience) noexcept : key_(*key), audience_(audience) {}

  /** Whether a hello is to be sent now. */
  bool isHelloDue(std::int64_t now_ns) const noexcept { return now_ns >= due_ns_; }
  /** The hello. @param[in] fresh random, used at most once. */
  HandshakeBytes hello(const Nonce& fresh, std::int64_t now_ns) noexcept;
  /** Takes an answer. @return false if it is not one to the newest hello. */
  bool receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns) noexcept;

  /** The receiver has answered: sign() can be used. */
  bool isOpen() const noexcept { return current_.isOpen() || next_.isOpen(); }
  SignedItpBytes sign(const ItpBytes& itp, bool pedal) noexcept;

 private:
  const ItpKey& key_;
  Audience audience_;
  ItpSession current_, next_;
  std::uint64_t counter_{0};
  Nonce nonce_{};
  bool asked_{false};
  std::int64_t due_ns_{0};
  std::int64_t pause_ns_{0};
};

}  // namespace raven2_trainer::wire
