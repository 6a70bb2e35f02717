#include "raven2_trainer/wire/session_table.h"

namespace raven2_trainer::wire {

Reject SessionTable::examine(const std::uint8_t* bytes, std::size_t size, Nonce* sender) const noexcept {
  return decodeHello(*key_, audience_, bytes, size, sender);
}

void SessionTable::answer(const Nonce& sender, const Nonce& fresh, HandshakeBytes* reply) noexcept {
  for (const Entry& entry : pending_) {
    if (!entry.session.isOpen() || entry.sender != sender) continue;
    *reply = encodeChallenge(*key_, audience_, sender, entry.receiver);
    return;
  }
  pending_[next_] = Entry{ItpSession(*key_, audience_, sender, fresh), ReplayWindow(), sender, fresh};
  next_ = (next_ + 1) % kPending;
  *reply = encodeChallenge(*key_, audience_, sender, fresh);
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
