#include "raven2_trainer/net/udp_receiver.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "binding.h"
#include "sockets.h"

namespace raven2_trainer::net {
namespace {

constexpr int kGuardBuffer = 4096;  // [bytes] samples of other senders, not a queue
constexpr int kPortAttempts = 16;   // a free port of the one socket may be taken for the other

FileDescriptor openBound(const Endpoint& endpoint, int* error) noexcept {
  FileDescriptor fd = openSocket(SOCK_DGRAM);
  const bool is_set = fd.isOpen() && setOption(fd.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  *error = is_set ? bindOnce(fd.get(), endpoint) : errno;
  return *error == 0 ? std::move(fd) : FileDescriptor();
}

/** Whether nobody has the port. Two sockets with SO_REUSEADDR would share it with a third; one without it shows that it
 * is taken. */
bool isFree(const Endpoint& endpoint, int* error) noexcept {
  const FileDescriptor probe = openSocket(SOCK_DGRAM);
  *error = probe.isOpen() ? bindOnce(probe.get(), endpoint) : errno;
  return *error == 0;
}

}  // namespace

UdpReceiver::UdpReceiver(const std::string& bind_address, std::uint16_t port, double patience) {
  const Endpoint endpoint = resolve(bind_address, port);
  bindPatiently("UDP receiver", endpoint, SOCK_DGRAM, patience, [&] { return bindBoth(endpoint); });
  for (const FileDescriptor* each : {&guard_, &fd_})
    setOption(each->get(), SOL_SOCKET, SO_REUSEADDR, 0);  // no third one, which would get our datagrams
  setOption(guard_.get(), SOL_SOCKET, SO_RCVBUF, kGuardBuffer);
  port_ = localEndpoint(fd_.get()).port;
}

int UdpReceiver::bindBoth(Endpoint endpoint) noexcept {
  const std::uint16_t port = endpoint.port;
  int error = 0;
  for (int attempt = 0; attempt < kPortAttempts && !fd_.isOpen(); ++attempt) {
    endpoint.port = port;
    guard_.close();  // of an attempt before: it has the port
    if (!isFree(endpoint, &error)) break;
    guard_ = openBound(endpoint, &error);
    if (!guard_.isOpen()) break;
    // By its number: a socket bound to "any" would lose its port when it is unpinned.
    endpoint.port = localEndpoint(guard_.get()).port;
    fd_ = openBound(endpoint, &error);
    if (!fd_.isOpen() && port != 0) break;
  }
  return fd_.isOpen() ? 0 : error;
}

bool UdpReceiver::wait(int timeout_ms) noexcept {
  pollfd entries[2] = {{fd_.get(), POLLIN, 0}, {guard_.get(), POLLIN, 0}};
  const nfds_t count = pinned_ ? 1 : 2;
  if (::poll(entries, count, std::max(timeout_ms, 0)) <= 0) return false;
  return entries[0].revents != 0 || (count == 2 && entries[1].revents != 0);
}

std::optional<Datagram> UdpReceiver::receive(std::uint8_t* buffer, std::size_t capacity) noexcept {
  const auto datagram = receiveFrom(fd_, buffer, capacity);
  return datagram || pinned_ ? datagram : receiveFrom(guard_, buffer, capacity);
}

std::optional<Datagram> UdpReceiver::receiveForeign(std::uint8_t* buffer, std::size_t capacity) noexcept {
  if (!pinned_) return std::nullopt;
  return receiveFrom(guard_, buffer, capacity);
}

std::optional<Datagram> UdpReceiver::receiveFrom(const FileDescriptor& fd,
                                                 std::uint8_t* buffer,
                                                 std::size_t capacity) noexcept {
  sockaddr_in address{};
  ssize_t size = -1;
  // "Connection refused" is the answer to one of our own datagrams, returned instead of the next one: ask again.
  for (int attempt = 0; attempt < 2 && size < 0; ++attempt) {
    socklen_t address_size = sizeof(address);
    // MSG_TRUNC: the size as sent, however much the buffer took.
    size = ::recvfrom(fd.get(), buffer, capacity, MSG_TRUNC | MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&address),
                      &address_size);
    if (size < 0 && errno != ECONNREFUSED) return std::nullopt;
  }
  if (size < 0) return std::nullopt;
  Datagram datagram;
  datagram.size = static_cast<std::size_t>(size);
  datagram.source = fromSockaddr(address);
  datagram.foreign = pinned_ && *pinned_ != datagram.source;
  return datagram;
}

bool UdpReceiver::sendTo(const Endpoint& to, const std::uint8_t* bytes, std::size_t size) noexcept {
  const sockaddr_in address = toSockaddr(to);
  return ::sendto(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address),
                  sizeof(address)) == static_cast<ssize_t>(size);
}

void UdpReceiver::pinSource(const Endpoint& source) noexcept {
  const sockaddr_in address = toSockaddr(source);
  // Refused or not: the mark of receiveFrom() is valid.
  static_cast<void>(::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)));
  pinned_ = source;
}

void UdpReceiver::unpinSource() noexcept {
  sockaddr_in nobody{};
  nobody.sin_family = AF_UNSPEC;
  static_cast<void>(::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&nobody), sizeof(nobody)));
  pinned_.reset();
}

}  // namespace raven2_trainer::net
