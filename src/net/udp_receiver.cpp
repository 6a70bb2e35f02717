#include "raven2_trainer/net/udp_receiver.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>

#include "sockets.h"

namespace raven2_trainer::net {

UdpReceiver::UdpReceiver(const std::string& bind_address, std::uint16_t port) {
  const Endpoint endpoint = resolve(bind_address, port);
  fd_ = openSocket(SOCK_DGRAM);
  if (!fd_.isOpen()) throwNetwork("UDP receiver", endpoint, "socket", errno);
  // No SO_REUSEADDR: it would let a second process take the port's datagrams.
  const sockaddr_in address = toSockaddr(endpoint);
  if (::bind(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    throwNetwork("UDP receiver", endpoint, "bind", errno);
  }
  port_ = localEndpoint(fd_.get()).port;
}

bool UdpReceiver::wait(int timeout_ms) noexcept {
  return (waitFor(fd_.get(), POLLIN, timeout_ms) & POLLIN) != 0;
}

std::optional<Datagram> UdpReceiver::receive(std::uint8_t* buffer, std::size_t capacity) noexcept {
  sockaddr_in address{};
  socklen_t address_size = sizeof(address);
  // MSG_TRUNC: the size as sent, however much the buffer took.
  const ssize_t size = ::recvfrom(fd_.get(), buffer, capacity, MSG_TRUNC | MSG_DONTWAIT,
                                  reinterpret_cast<sockaddr*>(&address), &address_size);
  if (size < 0) return std::nullopt;
  Datagram datagram;
  datagram.size = static_cast<std::size_t>(size);
  datagram.source = fromSockaddr(address);
  datagram.foreign = pinned_ && *pinned_ != datagram.source;
  return datagram;
}

}  // namespace raven2_trainer::net
