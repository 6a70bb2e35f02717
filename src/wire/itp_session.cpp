#include "raven2_trainer/wire/itp_session.h"

#include <sodium.h>

#include <algorithm>

#include "raven2_trainer/core/bytes.h"

namespace raven2_trainer::wire {
namespace {

using Head = std::array<std::uint8_t, 8>;
using Tag = std::array<std::uint8_t, kTagSize>;

constexpr std::size_t kHeadSize = 16;  ///< of the trailer: magic, session, counter
constexpr std::array<std::uint8_t, 4> kSignedMagic{'R', 'V', '2', 'S'};
constexpr std::uint8_t kVersion = 1;

/** The first bytes of whatever the key is used on: what the result is for, so that none can stand for another. */
Head headOf(char purpose, Audience audience) noexcept {
  return {'R', 'V', '2', static_cast<std::uint8_t>(purpose), kVersion, static_cast<std::uint8_t>(audience), 0, 0};
}

template <std::size_t N>
std::array<std::uint8_t, N> keyedHash(
    const std::uint8_t* key,
    std::initializer_list<std::pair<const std::uint8_t*, std::size_t>> parts) noexcept {
  crypto_generichash_state state;
  std::array<std::uint8_t, N> result{};
  crypto_generichash_init(&state, key, ItpKey::kSize, result.size());
  for (const auto& [bytes, size] : parts)
    crypto_generichash_update(&state, bytes, size);
  crypto_generichash_final(&state, result.data(), result.size());
  sodium_memzero(&state, sizeof(state));
  return result;
}

Tag helloTag(const ItpKey& key, const Head& head, const Nonce& sender) noexcept {
  return keyedHash<kTagSize>(key.data(), {{head.data(), head.size()}, {sender.data(), sender.size()}});
}

Tag challengeTag(const ItpKey& key, const Head& head, const Nonce& sender, const Nonce& receiver) noexcept {
  return keyedHash<kTagSize>(
      key.data(), {{head.data(), head.size()}, {sender.data(), sender.size()}, {receiver.data(), receiver.size()}});
}

HandshakeBytes message(const Head& head, const Nonce& nonce, const Tag& tag) noexcept {
  HandshakeBytes bytes;
  ByteWriter out(bytes.data(), bytes.size());
  out.putBytes(head.data(), head.size());
  out.putBytes(nonce.data(), nonce.size());
  out.putBytes(tag.data(), tag.size());
  return bytes;
}

/** Takes a message apart. @return kNone, kWrongSize or kBadFrame. */
Reject open(const std::uint8_t* bytes, std::size_t size, const Head& head, Nonce* nonce, Tag* tag) noexcept {
  if (size != kHandshakeSize) return Reject::kWrongSize;
  if (!std::equal(head.begin(), head.end(), bytes)) return Reject::kBadFrame;
  ByteReader in(bytes + head.size(), size - head.size());
  in.getBytes(nonce->data(), nonce->size());
  in.getBytes(tag->data(), tag->size());
  return Reject::kNone;
}

bool isEqual(const Tag& a, const std::uint8_t* b) noexcept {
  return sodium_memcmp(a.data(), b, a.size()) == 0;
}

}  // namespace

HandshakeBytes encodeHello(const ItpKey& key, Audience audience, const Nonce& sender) noexcept {
  const Head head = headOf('H', audience);
  return message(head, sender, helloTag(key, head, sender));
}

Reject decodeHello(const ItpKey& key,
                   Audience audience,
                   const std::uint8_t* bytes,
                   std::size_t size,
                   Nonce* sender) noexcept {
  const Head head = headOf('H', audience);
  Nonce nonce;
  Tag tag;
  const Reject reason = open(bytes, size, head, &nonce, &tag);
  if (reason != Reject::kNone) return reason;
  if (!isEqual(helloTag(key, head, nonce), tag.data())) return Reject::kBadSignature;
  *sender = nonce;
  return Reject::kNone;
}

HandshakeBytes encodeChallenge(const ItpKey& key,
                               Audience audience,
                               const Nonce& sender,
                               const Nonce& receiver) noexcept {
  const Head head = headOf('C', audience);
  return message(head, receiver, challengeTag(key, head, sender, receiver));
}

Reject decodeChallenge(const ItpKey& key,
                       Audience audience,
                       const Nonce& sender,
                       const std::uint8_t* bytes,
                       std::size_t size,
                       Nonce* receiver) noexcept {
  const Head head = headOf('C', audience);
  Nonce nonce;
  Tag tag;
  const Reject reason = open(bytes, size, head, &nonce, &tag);
  if (reason != Reject::kNone) return reason;
  if (!isEqual(challengeTag(key, head, sender, nonce), tag.data())) return Reject::kBadSignature;
  *receiver = nonce;
  return Reject::kNone;
}

ItpSession::ItpSession(const ItpKey& key, Audience audience, const Nonce& sender, const Nonce& receiver) noexcept
    : is_open_(true) {
  std::copy(sender.begin(), sender.end(), nonces_.begin());
  std::copy(receiver.begin(), receiver.end(), nonces_.begin() + kNonceSize);
  const Head head = headOf('K', audience);
  auto derived = keyedHash<64>(key.data(), {{head.data(), head.size()}, {nonces_.data(), nonces_.size()}});
  std::copy_n(derived.begin(), key_.size(), key_.begin());
  ByteReader in(derived.data() + key_.size(), sizeof(id_));
  id_ = in.get<std::uint32_t>();
  sodium_memzero(derived.data(), derived.size());
}

ItpSession::~ItpSession() {
  sodium_memzero(key_.data(), key_.size());
}

std::array<std::uint8_t, kTagSize> ItpSession::tagOf(const std::uint8_t* bytes) const noexcept {
  return keyedHash<kTagSize>(key_.data(), {{nonces_.data(), nonces_.size()}, {bytes, kItpSize + kHeadSize}});
}

SignedItpBytes ItpSession::sign(const ItpBytes& itp, std::uint64_t counter) const noexcept {
  SignedItpBytes bytes;
  ByteWriter out(bytes.data(), bytes.size());
  out.putBytes(itp.data(), itp.size());
  out.putBytes(kSignedMagic.data(), kSignedMagic.size());
  out.put(id_);
  out.put(counter);
  const Tag tag = tagOf(bytes.data());
  out.putBytes(tag.data(), tag.size());
  return bytes;
}

bool ItpSession::verify(const std::uint8_t* bytes) const noexcept {
  return is_open_ && isEqual(tagOf(bytes), bytes + kItpSize + kHeadSize);
}

bool decodeTrailer(const std::uint8_t* bytes, Trailer* trailer) noexcept {
  const std::uint8_t* head = bytes + kItpSize;
  if (!std::equal(kSignedMagic.begin(), kSignedMagic.end(), head)) return false;
  ByteReader in(head + kSignedMagic.size(), kHeadSize - kSignedMagic.size());
  trailer->session = in.get<std::uint32_t>();
  trailer->counter = in.get<std::uint64_t>();
  return true;
}

}  // namespace raven2_trainer::wire
