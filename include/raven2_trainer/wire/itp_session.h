#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/wire/itp.h"
#include "raven2_trainer/wire/itp_key.h"

// Signed ITP: a packet of 124 bytes and a trailer of 32. An unmodified Raven reads 124 bytes and uses them; a receiver
// with the key verifies sender, session and order. Bytes and handshake: doc/wire.md.

namespace raven2_trainer::wire {

constexpr std::size_t kTrailerSize = 32;
constexpr std::size_t kSignedItpSize = kItpSize + kTrailerSize;
constexpr std::size_t kNonceSize = 32;
constexpr std::size_t kTagSize = 16;
/** Size of both handshake messages. Smaller than a packet, so a Raven drops them; the answer is no larger than the
 *  question, so answers do not amplify a flood. */
constexpr std::size_t kHandshakeSize = 8 + kNonceSize + kTagSize;
static_assert(kHandshakeSize < kItpSize, "a Raven must not take it for a packet");

using Nonce = std::array<std::uint8_t, kNonceSize>;
using SignedItpBytes = std::array<std::uint8_t, kSignedItpSize>;
using HandshakeBytes = std::array<std::uint8_t, kHandshakeSize>;

/** Receiver of a session. It rejects packets that were signed for the other receiver. */
enum class Audience : std::uint8_t { kDaemon = 1, kRobot = 2 };

/** First message, sender to receiver: the sender's nonce, with a tag by the key. */
HandshakeBytes encodeHello(const ItpKey& key, Audience audience, const Nonce& sender) noexcept;
/** @return kNone, kWrongSize, kBadFrame (no hello, or for another audience) or kBadSignature. */
Reject decodeHello(const ItpKey& key,
                   Audience audience,
                   const std::uint8_t* bytes,
                   std::size_t size,
                   Nonce* sender) noexcept;

/** Second message, receiver to sender: the receiver's nonce, tied to the sender's. */
HandshakeBytes encodeChallenge(const ItpKey& key,
                               Audience audience,
                               const Nonce& sender,
                               const Nonce& receiver) noexcept;
/** As decodeHello(); kBadSignature also for an answer to another hello than that of `sender`. */
Reject decodeChallenge(const ItpKey& key,
                       Audience audience,
                       const Nonce& sender,
                       const std::uint8_t* bytes,
                       std::size_t size,
                       Nonce* receiver) noexcept;

/** Signs and verifies with the session key, which both sides derive from key and nonces. The destructor wipes it.
 *  Real-time safe: about 0.4 us a packet, no allocation. */
class ItpSession {
 public:
  ItpSession() noexcept = default;  ///< not open: verify() is always false
  ItpSession(const ItpKey& key, Audience audience, const Nonce& sender, const Nonce& receiver) noexcept;
  ItpSession(const ItpSession&) noexcept = default;
  ItpSession& operator=(const ItpSession&) noexcept = default;
  ~ItpSession();

  bool isOpen() const noexcept { return is_open_; }
  /** Names the session on the wire; no secret. */
  std::uint32_t id() const noexcept { return id_; }

  /** @param[in] counter 1 more each packet; never twice in a session. */
  SignedItpBytes sign(const ItpBytes& itp, std::uint64_t counter) const noexcept;

  /** Whether the tag of these kSignedItpSize bytes is valid; compared in constant time. */
  bool verify(const std::uint8_t* bytes) const noexcept;

 private:
  std::array<std::uint8_t, kTagSize> tagOf(const std::uint8_t* bytes) const noexcept;

  bool is_open_{false};
  std::uint32_t id_{0};
  std::array<std::uint8_t, 2 * kNonceSize> nonces_{};
  std::array<std::uint8_t, ItpKey::kSize> key_{};
};

/** The trailer's fields, before they are verified. */
struct Trailer {
  std::uint32_t session{};
  std::uint64_t counter{};
};

/** Of a datagram of kSignedItpSize bytes. @return false without the magic. */
bool decodeTrailer(const std::uint8_t* bytes, Trailer* trailer) noexcept;

}  // namespace raven2_trainer::wire
