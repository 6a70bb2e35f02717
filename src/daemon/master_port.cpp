#include "daemon/master_port.h"

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/itp_sender.h"
#include "raven2_trainer/net/key_file.h"

namespace raven2_trainer::daemon {
namespace {

constexpr int kMasterWaitMs = 50;
constexpr int kMaxDatagrams = 64;  // a wake-up
constexpr int kMaxForeign = 16;    // of others, for the count; the kernel drops the rest

}  // namespace

MasterPort::MasterPort(const NetworkConfig& network, const wire::ItpKey* key, SharedState* shared)
    : receiver_(network.bind_address, network.master_port), ingest_(network.itp, key, shared) {
  if (!network.master_address.empty()) ingest_.allowOnly(net::sourceId(net::resolve(network.master_address, 0)));
}

void MasterPort::tick() noexcept {
  receiver_.wait(kMasterWaitMs);
  std::array<std::uint8_t, 2 * wire::kSignedItpSize> buffer;
  for (int i = 0; i < kMaxDatagrams; ++i) {
    const auto datagram = receiver_.receive(buffer.data(), buffer.size());
    if (!datagram) break;
    take(buffer.data(), *datagram);
    followPin();
  }
  for (int i = 0; i < kMaxForeign; ++i) {
    const auto datagram = receiver_.receiveForeign(buffer.data(), buffer.size());
    if (!datagram) break;
    take(buffer.data(), *datagram);
  }
  ingest_.idle(net::monotonicNow());
  followPin();
}

void MasterPort::take(const std::uint8_t* bytes, const net::Datagram& datagram) noexcept {
  const wire::Arrival arrival{bytes, datagram.size, net::sourceId(datagram.source), net::monotonicNow()};
  if (!ingest_.isHello(arrival)) {
    ingest_.receive(arrival);
    return;
  }
  wire::HandshakeBytes reply;
  if (ingest_.answer(arrival, net::freshNonce(), &reply) != Reject::kNone) return;
  receiver_.sendTo(datagram.source, reply.data(), reply.size());
}

/** The socket hears whom the ingest hears. */
void MasterPort::followPin() noexcept {
  const auto& pinned = receiver_.pinnedSource();
  if (!ingest_.isPinned()) {
    if (pinned) receiver_.unpinSource();
  } else if (!pinned || net::sourceId(*pinned) != ingest_.source()) {
    receiver_.pinSource(net::endpointOf(ingest_.source()));
  }
}

}  // namespace raven2_trainer::daemon
