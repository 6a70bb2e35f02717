#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "raven2_trainer/net/udp_sender.h"
#include "raven2_trainer/wire/signed_sender.h"

namespace raven2_trainer::net {

/** Sends ITP, signed once the receiver has answered the handshake. One thread; real-time safe after construction. */
class ItpSender {
 public:
  enum class Unanswered : std::uint8_t {
    kPlain,    ///< until then unsigned packets: an unmodified Raven never answers
    kSilence,  ///< until then only the handshake
  };

  /** @param[in] key outlives this; nullptr: always plain. @throw NetworkException. */
  ItpSender(const std::string& host,
            std::uint16_t port,
            wire::Audience audience,
            const wire::ItpKey* key,
            Unanswered unanswered);

  /** One packet, and what the handshake needs. @return false if the system did not take it, or it stays silent. */
  bool send(const wire::ItpPacket& packet, std::int64_t now_ns) noexcept;

  /** Other packets than ITP, from the same socket: the receiver accepts them from the source of its ITP. Silent as
   * send() is.
   *  @return as send(). */
  bool sendPedals(const std::uint8_t* bytes, std::size_t size) noexcept;

  /** Packets go out signed. */
  bool isSigning() const noexcept { return signer_ && signer_->isOpen(); }

 private:
  void shakeHands(std::int64_t now_ns) noexcept;
  bool isSilent() const noexcept { return signer_ && !isSigning() && unanswered_ == Unanswered::kSilence; }

  net::UdpSender socket_;
  std::optional<wire::SignedSender> signer_;
  Unanswered unanswered_;
};

}  // namespace raven2_trainer::net
