#include "raven2_trainer/net/tcp_client.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "raven2_trainer/core/exceptions.h"
#include "sockets.h"

namespace raven2_trainer::net {
namespace {

constexpr double kNanosecondsPerSecond = 1e9;
constexpr std::int64_t kNanosecondsPerMillisecond = 1'000'000;

std::int64_t toNanoseconds(double seconds) noexcept {
  return static_cast<std::int64_t>(seconds * kNanosecondsPerSecond);
}

}  // namespace

TcpClient::TcpClient(const std::string& host, std::uint16_t port, double reconnect_min, double reconnect_max)
    : peer_(resolve(host, port)),
      pause_min_ns_(toNanoseconds(reconnect_min)),
      pause_max_ns_(toNanoseconds(reconnect_max)),
      pause_ns_(pause_min_ns_) {
  if (reconnect_min > 0.0 && reconnect_min <= reconnect_max) return;
  throw NetworkException("TCP client " + toString(peer_) + ": reconnect pauses " + std::to_string(reconnect_min) +
                         " and " + std::to_string(reconnect_max) + " s, expected 0 < min <= max");
}

TcpClient::Event TcpClient::poll(std::int64_t now_ns, int timeout_ms) noexcept {
  if (lost_) {
    lost_ = false;
    retryLater(now_ns);
    return Event::kDisconnected;
  }
  switch (state_) {
    case State::kDown:
      return pollDown(now_ns, timeout_ms);
    case State::kConnecting:
      return pollConnecting(now_ns, timeout_ms);
    case State::kUp:
      return pollUp(timeout_ms);
  }
  return Event::kNone;
}

TcpClient::Event TcpClient::pollDown(std::int64_t now_ns, int timeout_ms) noexcept {
  if (!has_tried_ || now_ns >= next_attempt_ns_) {
    startConnect(now_ns);
    if (state_ == State::kConnecting) return pollConnecting(now_ns, timeout_ms);
    return Event::kNone;
  }
  const std::int64_t left_ms = (next_attempt_ns_ - now_ns) / kNanosecondsPerMillisecond + 1;
  ::poll(nullptr, 0, static_cast<int>(std::clamp<std::int64_t>(timeout_ms, 0, left_ms)));
  return Event::kNone;
}

// A port above 32768 can be handed to the client itself: then it meets itself (simultaneous open) and would keep the
// server from ever binding. Such a connection does not count.
TcpClient::Event TcpClient::pollConnecting(std::int64_t now_ns, int timeout_ms) noexcept {
  const short events = waitFor(fd_.get(), POLLOUT, timeout_ms);
  if (events == 0) {
    if (now_ns >= give_up_ns_) retryLater(now_ns);
    return Event::kNone;
  }
  int error = 0;
  socklen_t size = sizeof(error);
  if (::getsockopt(fd_.get(), SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error != 0 ||
      localEndpoint(fd_.get()) == peer_) {
    retryLater(now_ns);
    return Event::kNone;
  }
  state_ = State::kUp;
  return Event::kConnected;
}

TcpClient::Event TcpClient::pollUp(int timeout_ms) noexcept {
  return waitFor(fd_.get(), POLLIN, timeout_ms) != 0 ? Event::kReadable : Event::kNone;
}

void TcpClient::startConnect(std::int64_t now_ns) noexcept {
  has_tried_ = true;
  ++attempts_;
  fd_ = openSocket(SOCK_STREAM);
  if (!fd_.isOpen()) return retryLater(now_ns);
  tuneTcp(fd_.get());
  setOption(fd_.get(), SOL_SOCKET, SO_RCVBUF, kTcpBuffer);  // before connecting: it bounds the window offered
  const sockaddr_in address = toSockaddr(peer_);
  const int result = ::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  if (result != 0 && errno != EINPROGRESS) return retryLater(now_ns);
  state_ = State::kConnecting;
  give_up_ns_ = now_ns + kConnectTimeoutNs;
}

void TcpClient::retryLater(std::int64_t now_ns) noexcept {
  fd_.close();
  state_ = State::kDown;
  next_attempt_ns_ = now_ns + pause_ns_;
  pause_ns_ = std::min(2 * pause_ns_, pause_max_ns_);
}

std::size_t TcpClient::receive(std::uint8_t* buffer, std::size_t capacity) noexcept {
  if (state_ != State::kUp || capacity == 0) return 0;
  const ssize_t size = ::recv(fd_.get(), buffer, capacity, MSG_DONTWAIT);
  if (size > 0) {
    pause_ns_ = pause_min_ns_;  // not before: a server without a place for us accepts and closes
    return static_cast<std::size_t>(size);
  }
  const bool is_nothing_yet = size < 0 && (errno == EAGAIN || errno == EINTR);
  if (!is_nothing_yet) disconnect();
  return 0;
}

bool TcpClient::send(const std::uint8_t* bytes, std::size_t size) noexcept {
  if (state_ != State::kUp) return false;
  const ssize_t sent = ::send(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(size)) return true;
  const bool is_full = sent < 0 && (errno == EAGAIN || errno == EINTR);
  if (!is_full) disconnect();
  return false;
}

void TcpClient::disconnect() noexcept {
  if (state_ == State::kUp) lost_ = true;
  fd_.close();
  state_ = State::kDown;
}

}  // namespace raven2_trainer::net
