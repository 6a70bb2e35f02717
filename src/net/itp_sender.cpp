#include "raven2_trainer/net/itp_sender.h"

#include <array>

#include "raven2_trainer/net/key_file.h"

namespace raven2_trainer::net {
namespace {

constexpr int kAnswersAtOnce = 8;

}  // namespace

ItpSender::ItpSender(const std::string& host,
                     std::uint16_t port,
                     wire::Audience audience,
                     const wire::ItpKey* key,
                     Unanswered unanswered)
    : socket_(host, port), unanswered_(unanswered) {
  if (key != nullptr) signer_.emplace(key, audience);
}

bool ItpSender::send(const wire::ItpPacket& packet, std::int64_t now_ns) noexcept {
  if (signer_) shakeHands(now_ns);
  const wire::ItpBytes plain = wire::encodeItp(packet);
  if (isSigning()) {
    const wire::SignedItpBytes bytes = signer_->sign(plain, packet.surgeon_mode != 0);
    return socket_.send(bytes.data(), bytes.size());
  }
  return !isSilent() && socket_.send(plain.data(), plain.size());
}

bool ItpSender::sendPedals(const std::uint8_t* bytes, std::size_t size) noexcept {
  return !isSilent() && socket_.send(bytes, size);
}

void ItpSender::shakeHands(std::int64_t now_ns) noexcept {
  std::array<std::uint8_t, 2 * wire::kHandshakeSize> buffer;
  for (int i = 0; i < kAnswersAtOnce; ++i) {
    const std::size_t size = socket_.receive(buffer.data(), buffer.size());
    if (size == 0) break;
    signer_->receive(buffer.data(), size, now_ns);
  }
  if (!signer_->isHelloDue(now_ns)) return;
  const wire::HandshakeBytes hello = signer_->hello(freshNonce(), now_ns);
  socket_.send(hello.data(), hello.size());
}

}  // namespace raven2_trainer::net
