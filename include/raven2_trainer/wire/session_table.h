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

  /** A hello and its answer; a repeated one gets the same. @param[in] fresh random, used at most once.
   *  @return as decodeHello(); `*reply` is filled with kNone only. */
  Reject answer(const std::uint8_t* bytes, std::size_t size, const Nonce& fresh, HandshakeBytes* reply) noexcept;

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
