#include "raven2_trainer/net/tcp_server.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "binding.h"
#include "outgoing_queue.h"
#include "raven2_trainer/net/endpoint.h"
#include "sockets.h"

namespace raven2_trainer::net {
namespace {

// Many clients must not fill it between two polls: a client that finds it full tries again after a second.
constexpr int kAcceptBacklog = 1024;
constexpr int kAcceptsPerPoll = 8;
constexpr int kReadsPerPoll = 4;
constexpr std::size_t kReadSize = 4096;

}  // namespace

struct TcpServer::Client {
  Client(ClientId client_id, FileDescriptor socket) : id(client_id), fd(std::move(socket)) {}

  ClientId id;
  FileDescriptor fd;
  OutgoingQueue queue{kQueueFrames};
  bool gone{false};
  bool has_taken{false};          // some byte, since the last poll
  std::int64_t waiting_since{0};  // [ns] the first poll at which something waited and nothing had been taken; 0 none
  bool has_part{false};           // of a message
  ReaderInfo info;
};

TcpServer::TcpServer(const std::string& bind_address, std::uint16_t port, double patience) {
  const Endpoint endpoint = resolve(bind_address, port);
  listening_ = openSocket(SOCK_STREAM);
  if (!listening_.isOpen()) throwNetwork("TCP server", endpoint, "socket", errno);
  setOption(listening_.get(), SOL_SOCKET, SO_REUSEADDR, 1);        // restart without waiting for old connections
  setOption(listening_.get(), SOL_SOCKET, SO_SNDBUF, kTcpBuffer);  // accepted sockets inherit both
  setOption(listening_.get(), SOL_SOCKET, SO_RCVBUF, kTcpBuffer);
  bindPatiently("TCP server", endpoint, SOCK_STREAM, patience, [&] { return bindOnce(listening_.get(), endpoint); });
  if (::listen(listening_.get(), kAcceptBacklog) != 0) throwNetwork("TCP server", endpoint, "listen", errno);
  port_ = localEndpoint(listening_.get()).port;
}

TcpServer::~TcpServer() = default;

void TcpServer::poll(int timeout_ms, Listener& listener, std::int64_t now_ns) {
  timeout_ms = std::max(timeout_ms, 0);
  now_ns_ = now_ns;
  std::array<pollfd, kMaxClients + 1> entries{};
  entries[kMaxClients] = {listening_.get(), POLLIN, 0};
  for (std::size_t i = 0; i < kMaxClients; ++i) {
    entries[i].fd = -1;  // ignored by poll
    if (!clients_[i]) continue;
    if (clients_[i]->gone) timeout_ms = 0;
    const short writing = clients_[i]->queue.size() > 0 ? POLLOUT : 0;
    entries[i] = {clients_[i]->fd.get(), static_cast<short>(POLLIN | writing), 0};
  }
  if (::poll(entries.data(), entries.size(), timeout_ms) > 0) {
    for (std::size_t i = 0; i < kMaxClients; ++i) {
      if (entries[i].fd < 0 || clients_[i]->gone) continue;
      if ((entries[i].revents & POLLOUT) != 0) flush(*clients_[i]);
      if ((entries[i].revents & (POLLIN | POLLHUP | POLLERR)) != 0) receiveFrom(*clients_[i], listener);
    }
    reap(listener);  // before accepting: places become free
    if ((entries[kMaxClients].revents & POLLIN) != 0) acceptAll(listener);
  }
  closeStalled();
  reap(listener);
}

void TcpServer::closeStalled() noexcept {
  for (const std::unique_ptr<Client>& place : clients_) {
    if (!place) continue;
    const bool is_waiting = place->queue.size() > 0 && !place->has_taken;
    place->has_taken = false;
    if (!is_waiting) place->waiting_since = 0;
    if (is_waiting && place->waiting_since == 0) place->waiting_since = now_ns_;
    if (!is_waiting || now_ns_ - place->waiting_since < kStallNs) continue;
    place->info.stalled = true;
    place->gone = true;
  }
}

void TcpServer::acceptAll(Listener& listener) {
  for (int i = 0; i < kAcceptsPerPoll; ++i) {
    sockaddr_in address{};
    socklen_t size = sizeof(address);
    FileDescriptor fd(
        ::accept4(listening_.get(), reinterpret_cast<sockaddr*>(&address), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!fd.isOpen()) return;
    admit(std::move(fd), fromSockaddr(address), listener);
  }
}

void TcpServer::admit(FileDescriptor fd, const Endpoint& peer, Listener& listener) {
  if (waitFor(fd.get(), POLLRDHUP, 0) != 0) return;  // it has left
  std::unique_ptr<Client>* place = findPlace();
  if (place == nullptr || !takeTurn()) {
    ++clients_refused_;
    return;
  }
  if (*place) evict(place, listener);
  tuneTcp(fd.get());
  *place = std::make_unique<Client>(next_id_++, std::move(fd));
  (*place)->info.peer = peer;
  listener.onConnect((*place)->id);
  receiveFrom(**place, listener);  // one that begins with half a message is known before the next one comes
}

/** Generic cell rate algorithm: as many at once as are left of the burst. */
bool TcpServer::takeTurn() noexcept {
  const std::int64_t turn = std::max(next_turn_ns_, now_ns_);
  if (turn - now_ns_ > (kAdmitBurst - 1) * kAdmitIntervalNs) return false;
  next_turn_ns_ = turn + kAdmitIntervalNs;
  return true;
}

void TcpServer::evict(std::unique_ptr<Client>* place, Listener& listener) {
  if (!(*place)->gone) ++clients_evicted_;
  close(place, listener);
}

/** The place to be had most readily, of these the oldest reader's; null if all behave. */
std::unique_ptr<TcpServer::Client>* TcpServer::findPlace() noexcept {
  std::unique_ptr<Client>* found = nullptr;
  for (std::unique_ptr<Client>& place : clients_) {
    const int best = found == nullptr ? 0 : readiness(found->get());
    const int ready = readiness(place.get());
    if (ready > best || (ready > 0 && ready == best && place && place->id < (*found)->id)) found = &place;
  }
  return found;
}

/** 0: it stays. */
int TcpServer::readiness(const Client* client) const noexcept {
  if (client == nullptr) return 4;
  if (client->gone) return 3;
  if (client->has_part) return 2;
  const bool is_idle = client->waiting_since != 0 && !client->has_taken && now_ns_ - client->waiting_since >= kYieldNs;
  return is_idle ? 1 : 0;
}

void TcpServer::receiveFrom(Client& client, Listener& listener) {
  std::array<std::uint8_t, kReadSize> buffer;
  for (int i = 0; i < kReadsPerPoll && !client.gone; ++i) {
    const ssize_t size = ::recv(client.fd.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (size > 0) {
      listener.onBytes(client.id, buffer.data(), static_cast<std::size_t>(size));
      continue;
    }
    const bool is_nothing_yet = size < 0 && (errno == EAGAIN || errno == EINTR);
    client.gone = !is_nothing_yet;
    return;
  }
}

bool TcpServer::send(ClientId client, const std::uint8_t* frame, std::size_t size) noexcept {
  if (size > wire::kMaxFrame) return false;
  for (const std::unique_ptr<Client>& place : clients_) {
    if (!place || place->id != client || place->gone) continue;
    enqueue(*place, frame, size);
    return true;
  }
  return false;
}

std::size_t TcpServer::broadcast(const std::uint8_t* frame, std::size_t size) noexcept {
  if (size > wire::kMaxFrame) return 0;
  std::size_t count = 0;
  for (const std::unique_ptr<Client>& place : clients_) {
    if (!place || place->gone) continue;
    enqueue(*place, frame, size);
    ++count;
  }
  return count;
}

void TcpServer::enqueue(Client& client, const std::uint8_t* frame, std::size_t size) noexcept {
  client.info.frames.dropped += client.queue.push(frame, size);
  ++client.info.frames.pushed;
  flush(client);
}

void TcpServer::flush(Client& client) noexcept {
  while (client.queue.size() > 0) {
    const ssize_t sent = ::send(client.fd.get(), client.queue.data(), client.queue.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) {
      client.gone = errno != EAGAIN && errno != EINTR;
      return;
    }
    if (client.queue.consume(static_cast<std::size_t>(sent))) ++client.info.frames.sent;
    client.has_taken = true;
  }
}

void TcpServer::drop(ClientId client) noexcept {
  for (const std::unique_ptr<Client>& place : clients_) {
    if (place && place->id == client) place->gone = true;
  }
}

void TcpServer::markPart(ClientId client, bool has_part) noexcept {
  for (const std::unique_ptr<Client>& place : clients_) {
    if (place && place->id == client) place->has_part = has_part;
  }
}

void TcpServer::reap(Listener& listener) {
  for (std::unique_ptr<Client>& place : clients_) {
    if (place && place->gone) close(&place, listener);
  }
}

void TcpServer::close(std::unique_ptr<Client>* place, Listener& listener) {
  (*place)->gone = true;
  listener.onDisconnect((*place)->id);
  const FrameTotals& frames = (*place)->info.frames;
  gone_.pushed += frames.pushed;
  gone_.sent += frames.sent;
  gone_.dropped += frames.dropped;
  gone_.unsent += (*place)->queue.frames();
  place->reset();
}

FrameTotals TcpServer::totals() const noexcept {
  FrameTotals all = gone_;
  for (const std::unique_ptr<Client>& place : clients_) {
    if (!place) continue;
    all.pushed += place->info.frames.pushed;
    all.sent += place->info.frames.sent;
    all.dropped += place->info.frames.dropped;
    all.queued += place->queue.frames();
  }
  return all;
}

TcpServer::ReaderInfo TcpServer::reader(ClientId client) const noexcept {
  for (const std::unique_ptr<Client>& place : clients_) {
    if (!place || place->id != client) continue;
    ReaderInfo info = place->info;
    info.frames.queued = place->queue.frames();
    return info;
  }
  return {};
}

std::size_t TcpServer::clientCount() const noexcept {
  std::size_t count = 0;
  for (const std::unique_ptr<Client>& place : clients_) {
    if (place && !place->gone) ++count;
  }
  return count;
}

}  // namespace raven2_trainer::net
