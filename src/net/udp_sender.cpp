#include "raven2_trainer/net/udp_sender.h"

#include <sys/socket.h>

#include <cerrno>

#include "raven2_trainer/net/endpoint.h"
#include "sockets.h"

namespace raven2_trainer::net {

UdpSender::UdpSender(const std::string& host, std::uint16_t port) {
  const Endpoint endpoint = resolve(host, port);
  fd_ = openSocket(SOCK_DGRAM);
  if (!fd_.isOpen()) throwNetwork("UDP sender", endpoint, "socket", errno);
  const sockaddr_in address = toSockaddr(endpoint);
  if (::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    throwNetwork("UDP sender", endpoint, "connect", errno);
  }
  port_ = localEndpoint(fd_.get()).port;
}

bool UdpSender::send(const std::uint8_t* bytes, std::size_t size) noexcept {
  // "Connection refused" is the answer to an earlier datagram, returned instead of sending this one: send it again.
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (::send(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size)) return true;
    if (errno != ECONNREFUSED) return false;
  }
  return true;
}

std::size_t UdpSender::receive(std::uint8_t* buffer, std::size_t capacity) noexcept {
  const ssize_t size = ::recv(fd_.get(), buffer, capacity, MSG_TRUNC | MSG_DONTWAIT);
  return size > 0 ? static_cast<std::size_t>(size) : 0;
}

}  // namespace raven2_trainer::net
