#include "sockets.h"

#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::net {

void throwNetwork(const std::string& what, const Endpoint& endpoint, const char* call, int error) {
  throw NetworkException(what + " " + toString(endpoint) + ": " + call + ": " + std::strerror(error));
}

sockaddr_in toSockaddr(const Endpoint& endpoint) noexcept {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(endpoint.address);
  address.sin_port = htons(endpoint.port);
  return address;
}

Endpoint fromSockaddr(const sockaddr_in& address) noexcept {
  return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

FileDescriptor openSocket(int type) noexcept {
  return FileDescriptor(::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

bool setOption(int fd, int level, int option, int value) noexcept {
  return ::setsockopt(fd, level, option, &value, sizeof(value)) == 0;
}

void tuneTcp(int fd) noexcept {
  setOption(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  setOption(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  setOption(fd, IPPROTO_TCP, TCP_KEEPIDLE, 1);
  setOption(fd, IPPROTO_TCP, TCP_KEEPINTVL, 1);
  setOption(fd, IPPROTO_TCP, TCP_KEEPCNT, 3);
  setOption(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, 2000);
}

Endpoint localEndpoint(int fd) noexcept {
  sockaddr_in address{};
  socklen_t size = sizeof(address);
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  return fromSockaddr(address);
}

short waitFor(int fd, short events, int timeout_ms) noexcept {
  pollfd entry{fd, events, 0};
  return ::poll(&entry, 1, std::max(timeout_ms, 0)) > 0 ? entry.revents : short{0};
}

}  // namespace raven2_trainer::net
