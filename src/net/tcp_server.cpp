#include "raven2_trainer/net/tcp_server.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "outgoing_queue.h"
#include "raven2_trainer/net/endpoint.h"
#include "sockets.h"

namespace raven2_trainer::net {
namespace {

constexpr int kAcceptBacklog = 8;  // reliability.md 2.2, rule 10
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
  ReaderInfo info;
};

TcpServer::TcpServer(const std::string& bind_address, std::uint16_t port) {
  const Endpoint endpoint = resolve(bind_address, port);
  listening_ = openSocket(SOCK_STREAM);
  if (!listening_.isOpen()) throwNetwork("TCP server", endpoint, "socket", errno);
  setOption(listening_.get(), SOL_SOCKET, SO_REUSEADDR, 1);        // restart without waiting for old connections
  setOption(listening_.get(), SOL_SOCKET, SO_SNDBUF, kTcpBuffer);  // accepted sockets inherit both
  setOption(listening_.get(), SOL_SOCKET, SO_RCVBUF, kTcpBuffer);
  const sockaddr_in address = toSockaddr(endpoint);
  if (::bind(listening_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    throwNetwork("TCP server", endpoint, "bind", errno);
  }
  if (::listen(listening_.get(), kAcceptBacklog) != 0) throwNetwork("TCP server", endpoint, "listen", errno);
  port_ = localEndpoint(listening_.get()).port;
}

TcpServer::~TcpServer() = default;

void TcpServer::poll(int timeout_ms, Listener& listener, std::int64_t now_ns) {
  timeout_ms = std::max(timeout_ms, 0);
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
  closeStalled(now_ns);
  reap(listener);
}

void TcpServer::closeStalled(std::int64_t now_ns) noexcept {
  for (const std::unique_ptr<Client>& place : clients_) {
    if (!place) continue;
    const bool is_waiting = place->queue.size() > 0 && !place->has_taken;
    place->has_taken = false;
    if (!is_waiting) place->waiting_since = 0;
    if (is_waiting && place->waiting_since == 0) place->waiting_since = now_ns;
    if (!is_waiting || now_ns - place->waiting_since < kStallNs) continue;
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
  for (std::unique_ptr<Client>& place : clients_) {
    if (place) continue;
    tuneTcp(fd.get());
    place = std::make_unique<Client>(next_id_++, std::move(fd));
    place->info.peer = peer;
    listener.onConnect(place->id);
    return;
  }
  ++clients_refused_;
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
  const std::size_t dropped = client.queue.push(frame, size);
  ++client.info.frames_sent;
  client.info.frames_dropped += dropped;
  frames_dropped_ += dropped;
  flush(client);
}

void TcpServer::flush(Client& client) noexcept {
  while (client.queue.size() > 0) {
    const ssize_t sent = ::send(client.fd.get(), client.queue.data(), client.queue.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) {
      client.gone = errno != EAGAIN && errno != EINTR;
      return;
    }
    client.queue.consume(static_cast<std::size_t>(sent));
    client.has_taken = true;
  }
}

void TcpServer::drop(ClientId client) noexcept {
  for (const std::unique_ptr<Client>& place : clients_) {
    if (place && place->id == client) place->gone = true;
  }
}

void TcpServer::reap(Listener& listener) {
  for (std::unique_ptr<Client>& place : clients_) {
    if (!place || !place->gone) continue;
    listener.onDisconnect(place->id);
    place.reset();
  }
}

TcpServer::ReaderInfo TcpServer::reader(ClientId client) const noexcept {
  for (const std::unique_ptr<Client>& place : clients_) {
    if (place && place->id == client) return place->info;
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
