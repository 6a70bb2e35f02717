#include "raven2_trainer/wire/session_table.h"

namespace raven2_trainer::wire {

Reject SessionTable::answer(const std::uint8_t* bytes,
                            std::size_t size,
                            const Nonce& fresh,
                            HandshakeBytes* reply) noexcept {
  Nonce sender;
  const Reject reason = decodeHello(*key_, audience_, bytes, size, &sender);
  if (reason != Reject::kNone) return reason;
  for (const Entry& entry : pending_) {
    if (!entry.session.isOpen() || entry.sender != sender) continue;
    *reply = encodeChallenge(*key_, audience_, sender, entry.receiver);
    return Reject::kNone;
  }
  pending_[next_] = Entry{ItpSession(*key_, audience_, sender, fresh), ReplayWindow(), sender, fresh};
  next_ = (next_ + 1) % kPending;
  *reply = encodeChallenge(*key_, audience_, sender, fresh);
  return Reject::kNone;
}

SessionTable::Entry* SessionTable::find(std::uint32_t session) noexcept {
  if (current_.session.isOpen() && current_.session.id() == session) return &current_;
  for (Entry& entry : pending_) {
    if (entry.session.isOpen() && entry.session.id() == session) return &entry;
  }
  return nullptr;
}

SessionTable::Entry* SessionTable::promote(Entry* entry) noexcept {
  current_ = *entry;
  *entry = Entry{};
  return &current_;
}

}  // namespace raven2_trainer::wire
