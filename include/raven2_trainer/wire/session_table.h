#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/wire/itp_session.h"
#include "raven2_trainer/wire/replay_window.h"

namespace raven2_trainer::wire {

/**
 * The receiver's sessions: the one in force, and those that a hello asked for and no packet has proven yet. A hello,
 * forged, replayed or honest, changes nothing of the one in force. Real-time safe; nonces come from outside.
 */
class SessionTable {
 public:
  static constexpr std::size_t kPending = 4;

  struct Entry {
    ItpSession session;
    ReplayWindow window;
    Nonce sender{}, receiver{};
  };

  /** `key` outlives this. */
  SessionTable(const ItpKey* key, Audience audience) noexcept : key_(key), audience_(audience) {}

  /** Whether this is a hello of one who has the key. @return as decodeHello(); `*sender` is filled with kNone only. */
  Reject examine(const std::uint8_t* bytes, std::size_t size, Nonce* sender) const noexcept;

  /** The answer to a hello; a repeated one gets the same. @param[in] fresh random, used at most once. */
  void answer(const Nonce& sender, const Nonce& fresh, HandshakeBytes* reply) noexcept;

  /** Whose packet this claims to be; its tag is still to be verified. nullptr: of none that is known. */
  Entry* find(std::uint32_t session) noexcept;

  bool isInForce(const Entry& entry) const noexcept { return &entry == &current_; }
  /** Puts a pending session in force, in place of the one before. `entry` is gone afterwards. */
  Entry* promote(Entry* entry) noexcept;

 private:
  const ItpKey* key_;
  Audience audience_;
  Entry current_;
  std::array<Entry, kPending> pending_;
  std::size_t next_{0};
};

}  // namespace raven2_trainer::wire
