#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"
#include "raven2_trainer/net/udp_receiver.h"

namespace raven2_trainer::net {

/** A UDP socket that both sends and receives, for a program between two others. Non-blocking; after construction
 *  it neither throws nor allocates. */
class UdpSocket {
 public:
  /** Listens. Parameters and errors are those of UdpReceiver. */
  static UdpSocket bound(const std::string& address, std::uint16_t port, double patience = kBindPatience);

  /** Talks to one peer and hears of nobody else. @throw NetworkException. */
  static UdpSocket connected(const Endpoint& peer);

  /** Next datagram waiting, not longer than `capacity` or else cut to it. */
  std::optional<Datagram> receive(std::uint8_t* buffer, std::size_t capacity) noexcept;

  /** To the peer of a connected socket. @return false if the system did not take it. */
  bool send(const std::uint8_t* bytes, std::size_t size) noexcept;

  /** To anybody, from a bound socket. */
  bool sendTo(const Endpoint& peer, const std::uint8_t* bytes, std::size_t size) noexcept;

  std::uint16_t port() const noexcept { return port_; }
  int fd() const noexcept { return fd_.get(); }

 private:
  explicit UdpSocket(FileDescriptor fd) noexcept;

  FileDescriptor fd_;
  std::uint16_t port_{0};
};

}  // namespace raven2_trainer::net
