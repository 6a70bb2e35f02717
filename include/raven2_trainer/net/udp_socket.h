#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"
#include "raven2_trainer/net/udp_receiver.h"

namespace raven2_trainer::net {

/** A UDP socket that sends and receives, for a proxy. Non-blocking; after construction it neither throws nor
 *  allocates. */
class UdpSocket {
 public:
  /** Binds to a local address. Parameters and errors: see UdpReceiver. */
  static UdpSocket bound(const std::string& address, std::uint16_t port, double patience = kBindPatience);

  /** Connects to one peer; receives only from this peer. @throw NetworkException. */
  static UdpSocket connected(const Endpoint& peer);

  /** Next datagram, cut to `capacity` bytes, or nullopt if none waits. */
  std::optional<Datagram> receive(std::uint8_t* buffer, std::size_t capacity) noexcept;

  /** Sends to the peer of a connected socket. @return false on any error except a peer that refuses. */
  bool send(const std::uint8_t* bytes, std::size_t size) noexcept;

  /** Sends from a bound socket, without send()'s second try. @return false on any error. */
  bool sendTo(const Endpoint& peer, const std::uint8_t* bytes, std::size_t size) noexcept;

  std::uint16_t port() const noexcept { return port_; }
  int fd() const noexcept { return fd_.get(); }

 private:
  explicit UdpSocket(FileDescriptor fd) noexcept;

  FileDescriptor fd_;
  std::uint16_t port_{0};
};

}  // namespace raven2_trainer::net
