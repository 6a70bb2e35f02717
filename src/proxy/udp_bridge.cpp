#include "proxy/udp_bridge.h"

#include <algorithm>

#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::proxy {
namespace {

constexpr std::size_t kLargestDatagram = 65536;
constexpr int kMostAtOnce = 256;  // [datagrams] a flood on one link must not starve the others
constexpr std::size_t kForward = 0, kBack = 1;

}  // namespace

UdpBridge::UdpBridge(const ProxyLink& link,
                     std::uint64_t seed,
                     std::uint64_t stream,
                     std::int64_t start_ns,
                     ImpairmentLog* log)
    : front_(net::UdpSocket::bound(link.listen_address, link.listen_port)),
      back_(net::UdpSocket::connected(net::resolve(link.target_host, link.target_port))),
      name_("udp " + std::to_string(front_.port())),
      directions_{Direction{"forward", name_ + ",forward", {link.forward, seed, stream, start_ns}},
                  Direction{"back", name_ + ",back", {link.back, seed, stream + 1, start_ns}}},
      buffer_(kLargestDatagram),
      log_(*log) {}

void UdpBridge::watch(net::PollSet* poll) const {
  poll->add(front_.fd(), /*to_read=*/true, /*to_write=*/false);
  poll->add(back_.fd(), /*to_read=*/true, /*to_write=*/false);
}

std::optional<std::int64_t> UdpBridge::nextDue() const noexcept {
  const auto forward = directions_[kForward].channel.nextDue();
  const auto back = directions_[kBack].channel.nextDue();
  if (!forward || !back) return forward ? forward : back;
  return std::min(*forward, *back);
}

void UdpBridge::receive() {
  take(&front_, &directions_[kForward]);
  take(&back_, &directions_[kBack]);
}

void UdpBridge::take(net::UdpSocket* socket, Direction* direction) {
  for (int i = 0; i < kMostAtOnce; ++i) {
    const auto datagram = socket->receive(buffer_.data(), buffer_.size());
    if (!datagram) return;
    if (socket == &front_) sender_ = datagram->source;
    const std::int64_t now_ns = net::monotonicNow();
    const std::int64_t sequence = ImpairmentLog::sequenceOf(buffer_.data(), datagram->size);
    const impair::Fate fate = direction->channel.offer(buffer_.data(), datagram->size, now_ns, sequence);
    if (fate.loss != impair::Loss::kNone) log_.dropped(direction->where, fate, sequence, datagram->size, now_ns);
  }
}

void UdpBridge::deliver() {
  for (Direction& direction : directions_) {
    const bool is_forward = &direction == &directions_[kForward];
    while (const auto packet = direction.channel.take(net::monotonicNow())) {
      const bool sent = send(is_forward, *packet);
      if (!sent) ++direction.unsent;
      log_.out(direction.where, *packet, sent ? "sent" : "unsent", net::monotonicNow());
    }
  }
}

bool UdpBridge::send(bool is_forward, const impair::Delivery& packet) noexcept {
  if (is_forward) return back_.send(packet.bytes.data(), packet.bytes.size());
  return sender_ && front_.sendTo(*sender_, packet.bytes.data(), packet.bytes.size());
}

void UdpBridge::finish() {
  const std::int64_t now_ns = net::monotonicNow();
  for (Direction& direction : directions_) {
    impair::Channel rest = direction.channel;
    while (const auto due = rest.nextDue())
      log_.out(direction.where, *rest.take(*due), "held", now_ns);
  }
}

void UdpBridge::report(std::vector<ProxyReport>* all) const {
  for (const Direction& direction : directions_)
    all->push_back({name_, direction.name, direction.channel.counts(), direction.unsent, 0});
}

}  // namespace raven2_trainer::proxy
