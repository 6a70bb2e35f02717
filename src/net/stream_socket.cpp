#include "raven2_trainer/net/stream_socket.h"

#include <sys/socket.h>

#include <cerrno>
#include <utility>

#include "binding.h"
#include "sockets.h"

namespace raven2_trainer::net {
namespace {

constexpr int kBacklog = 8;

StreamSocket::Moved failed() noexcept {
  const bool later = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR || errno == ENOTCONN;
  return {later ? StreamSocket::Result::kWouldBlock : StreamSocket::Result::kError, 0};
}

}  // namespace

StreamSocket::StreamSocket(FileDescriptor fd) noexcept : fd_(std::move(fd)) {
  tuneTcp(fd_.get());
}

std::optional<StreamSocket> StreamSocket::connecting(const Endpoint& peer) noexcept {
  FileDescriptor fd = openSocket(SOCK_STREAM);
  if (!fd.isOpen()) return std::nullopt;
  const sockaddr_in name = toSockaddr(peer);
  const bool failed = ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&name), sizeof(name)) != 0;
  if (failed && errno != EINPROGRESS) return std::nullopt;
  return StreamSocket(std::move(fd));
}

StreamSocket::Moved StreamSocket::receive(std::uint8_t* buffer, std::size_t capacity) noexcept {
  const ssize_t size = ::recv(fd_.get(), buffer, capacity, MSG_DONTWAIT);
  if (size < 0) return failed();
  return {size == 0 ? Result::kEnd : Result::kDone, static_cast<std::size_t>(size)};
}

StreamSocket::Moved StreamSocket::send(const std::uint8_t* bytes, std::size_t size) noexcept {
  const ssize_t sent = ::send(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent < 0) return failed();
  return {Result::kDone, static_cast<std::size_t>(sent)};
}

void StreamSocket::endSending() noexcept {
  ::shutdown(fd_.get(), SHUT_WR);
}

StreamListener::StreamListener(const std::string& address, std::uint16_t port, double patience) {
  const Endpoint endpoint = resolve(address, port);
  fd_ = openSocket(SOCK_STREAM);
  if (!fd_.isOpen()) throwNetwork("TCP", endpoint, "socket", errno);
  setOption(fd_.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  bindPatiently("TCP", endpoint, SOCK_STREAM, patience, [&] { return bindOnce(fd_.get(), endpoint); });
  if (::listen(fd_.get(), kBacklog) != 0) throwNetwork("TCP", endpoint, "listen", errno);
  port_ = localEndpoint(fd_.get()).port;
}

std::optional<StreamSocket> StreamListener::accept() noexcept {
  FileDescriptor fd(::accept4(fd_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (!fd.isOpen()) return std::nullopt;
  return StreamSocket(std::move(fd));
}

}  // namespace raven2_trainer::net
