#include "proxy/tcp_bridge.h"

#include <algorithm>
#include <utility>

#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::proxy {
namespace {

constexpr std::size_t kPiece = 16384;  // [bytes]
// [bytes] under way in one direction: 0.8 s of state frames. Then the source has to wait, as with a full TCP window.
constexpr std::size_t kWindowBytes = 512 * 1024;
constexpr std::array<const char*, 2> kDirections{"forward", "back"};

}  // namespace

TcpBridge::TcpBridge(const ProxyLink& link,
                     std::uint64_t seed,
                     std::uint64_t stream,
                     std::int64_t start_ns,
                     ImpairmentLog* log)
    : link_(link),
      seed_(seed),
      stream_(stream),
      start_ns_(start_ns),
      target_(net::resolve(link.target_host, link.target_port)),
      listener_(link.listen_address, link.listen_port),
      name_("tcp " + std::to_string(listener_.port())),
      where_{name_ + ",forward", name_ + ",back"},
      buffer_(kPiece),
      log_(*log) {}

void TcpBridge::watch(net::PollSet* poll) const {
  poll->add(listener_.fd(), connections_.size() < kMaxConnections, /*to_write=*/false);
  for (const auto& connection : connections_) {
    for (const std::size_t side : {0U, 1U}) {
      const Way& incoming = connection->ways[1 - side];
      poll->add(connection->sockets[side].fd(), mayRead(*connection, side), incoming.sent < incoming.out.size());
    }
  }
}

bool TcpBridge::mayRead(const Connection& connection, std::size_t side) const noexcept {
  const Way& way = connection.ways[side];
  return !way.ended && way.channel.heldBytes() + way.out.size() - way.sent < kWindowBytes;
}

std::optional<std::int64_t> TcpBridge::nextDue() const noexcept {
  std::optional<std::int64_t> first;
  for (const auto& connection : connections_) {
    for (const Way& way : connection->ways) {
      const auto due = way.channel.nextDue();
      if (due) first = first ? std::min(*first, *due) : *due;
    }
  }
  return first;
}

void TcpBridge::receive() {
  acceptAll();
  for (const auto& connection : connections_) {
    for (const std::size_t side : {0U, 1U})
      receiveFrom(connection.get(), side);
  }
}

void TcpBridge::acceptAll() {
  while (connections_.size() < kMaxConnections) {
    auto client = listener_.accept();
    if (!client) return;
    auto target = net::StreamSocket::connecting(target_);
    if (!target) continue;
    const std::uint64_t stream = stream_ + 2 * (accepted_++ % (kStreams / 2));
    const auto way = [&](const Impairment& impairment, std::uint64_t which) {
      return Way{impair::Channel(impairment, seed_, stream + which, start_ns_, impair::Medium::kStream), {}};
    };
    connections_.push_back(std::make_unique<Connection>(
        Connection{{std::move(*client), std::move(*target)}, {way(link_.forward, 0), way(link_.back, 1)}}));
  }
}

void TcpBridge::receiveFrom(Connection* connection, std::size_t side) {
  Way& way = connection->ways[side];
  while (mayRead(*connection, side) && !connection->broken) {
    const auto moved = connection->sockets[side].receive(buffer_.data(), buffer_.size());
    if (moved.result == net::StreamSocket::Result::kWouldBlock) return;
    connection->broken = moved.result == net::StreamSocket::Result::kError;
    way.ended = moved.result == net::StreamSocket::Result::kEnd;
    if (moved.count > 0) way.channel.offer(buffer_.data(), moved.count, net::monotonicNow(), -1);
    if (moved.count < buffer_.size()) return;
  }
}

void TcpBridge::deliver() {
  for (const auto& connection : connections_) {
    for (const std::size_t side : {0U, 1U})
      deliverTo(connection.get(), side);
  }
  reap();
}

/** Sends the bytes of one side to the other. */
void TcpBridge::deliverTo(Connection* connection, std::size_t side) {
  Way& way = connection->ways[side];
  while (const auto piece = way.channel.take(net::monotonicNow())) {
    way.out.insert(way.out.end(), piece->bytes.begin(), piece->bytes.end());
    log_.out(where_[side], *piece, "sent", net::monotonicNow());
  }
  flush(connection, side);
  if (way.ended && !way.end_reported && way.out.empty() && way.channel.counts().held == 0) {
    connection->sockets[1 - side].endSending();
    way.end_reported = true;
  }
}

void TcpBridge::flush(Connection* connection, std::size_t side) {
  Way& way = connection->ways[side];
  while (way.sent < way.out.size()) {
    const auto moved = connection->sockets[1 - side].send(way.out.data() + way.sent, way.out.size() - way.sent);
    if (moved.result == net::StreamSocket::Result::kError) connection->broken = true;
    if (moved.result != net::StreamSocket::Result::kDone) return;
    way.sent += moved.count;
    if (way.sent < kWindowBytes) continue;
    way.out.erase(way.out.begin(), way.out.begin() + static_cast<std::ptrdiff_t>(way.sent));  // a slow reader's past
    way.sent = 0;
  }
  way.out.clear();
  way.sent = 0;
}

/** Takes away the connections that both sides have ended, or one has broken. */
void TcpBridge::reap() {
  for (auto connection = connections_.begin(); connection != connections_.end();) {
    auto& ways = (*connection)->ways;
    if (!(*connection)->broken && !(ways[0].end_reported && ways[1].end_reported)) {
      ++connection;
      continue;
    }
    for (const std::size_t side : {0U, 1U})
      close(side, &ways[side].channel);
    connection = connections_.erase(connection);
  }
}

/** The pieces that a broken connection held are not sent, and the log says so. */
void TcpBridge::close(std::size_t side, impair::Channel* channel) {
  unsent_[side] += channel->counts().held;
  while (const auto due = channel->nextDue())
    log_.out(where_[side], *channel->take(*due), "unsent", net::monotonicNow());
  closed_[side] += channel->counts();
}

void TcpBridge::finish() {
  const std::int64_t now_ns = net::monotonicNow();
  for (const auto& connection : connections_) {
    for (const std::size_t side : {0U, 1U}) {
      impair::Channel rest = connection->ways[side].channel;
      while (const auto due = rest.nextDue())
        log_.out(where_[side], *rest.take(*due), "held", now_ns);
    }
  }
}

void TcpBridge::report(std::vector<ProxyReport>* all) const {
  for (const std::size_t side : {0U, 1U}) {
    ProxyReport report{name_, kDirections[side], closed_[side], unsent_[side], accepted_};
    for (const auto& connection : connections_)
      report.counts += connection->ways[side].channel.counts();
    all->push_back(report);
  }
}

}  // namespace raven2_trainer::proxy
