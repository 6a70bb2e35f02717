#include "raven2_trainer/net/udp_socket.h"

#include <sys/socket.h>

#include <cerrno>
#include <utility>

#include "binding.h"
#include "sockets.h"

namespace raven2_trainer::net {
namespace {

// [bytes] some 4,000 packets of ITP with the kernel's overhead: a stall of seconds on a busy computer loses none.
constexpr int kReceiveBuffer = 4 << 20;

FileDescriptor open(const Endpoint& endpoint) {
  FileDescriptor fd = openSocket(SOCK_DGRAM);
  if (!fd.isOpen()) throwNetwork("UDP", endpoint, "socket", errno);
  // The first is granted to root whatever the system's limit; else as much as the limit allows.
  if (!setOption(fd.get(), SOL_SOCKET, SO_RCVBUFFORCE, kReceiveBuffer)) {
    setOption(fd.get(), SOL_SOCKET, SO_RCVBUF, kReceiveBuffer);
  }
  return fd;
}

}  // namespace

UdpSocket::UdpSocket(FileDescriptor fd) noexcept : fd_(std::move(fd)), port_(localEndpoint(fd_.get()).port) {}

UdpSocket UdpSocket::bound(const std::string& address, std::uint16_t port, double patience) {
  const Endpoint endpoint = resolve(address, port);
  FileDescriptor fd = open(endpoint);
  bindPatiently("UDP", endpoint, SOCK_DGRAM, patience, [&] { return bindOnce(fd.get(), endpoint); });
  return UdpSocket(std::move(fd));
}

UdpSocket UdpSocket::connected(const Endpoint& peer) {
  FileDescriptor fd = open(peer);
  const sockaddr_in name = toSockaddr(peer);
  if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&name), sizeof(name)) != 0) {
    throwNetwork("UDP", peer, "connect", errno);
  }
  return UdpSocket(std::move(fd));
}

std::optional<Datagram> UdpSocket::receive(std::uint8_t* buffer, std::size_t capacity) noexcept {
  sockaddr_in address{};
  socklen_t address_size = sizeof(address);
  const ssize_t size =
      ::recvfrom(fd_.get(), buffer, capacity, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&address), &address_size);
  if (size < 0) return std::nullopt;
  Datagram datagram;
  datagram.size = static_cast<std::size_t>(size);
  datagram.source = fromSockaddr(address);
  return datagram;
}

bool UdpSocket::send(const std::uint8_t* bytes, std::size_t size) noexcept {
  // "Connection refused" is the answer to an earlier datagram, returned instead of sending this one: send it again.
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (::send(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size)) return true;
    if (errno != ECONNREFUSED) return false;
  }
  return true;
}

bool UdpSocket::sendTo(const Endpoint& peer, const std::uint8_t* bytes, std::size_t size) noexcept {
  const sockaddr_in name = toSockaddr(peer);
  return ::sendto(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&name),
                  sizeof(name)) == static_cast<ssize_t>(size);
}

}  // namespace raven2_trainer::net
