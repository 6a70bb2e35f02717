#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

/** A UDP socket connected to one receiver: it keeps one source port and hears of nobody else. */
class UdpSender {
 public:
  /** @throw NetworkException with host, port and the system's error. The receiver need not be there. */
  UdpSender(const std::string& host, std::uint16_t port);

  /** Sends one datagram, never waits. @return false if the system did not take it; a receiver that is not there is no
   *  failure, as for any UDP. */
  bool send(const std::uint8_t* bytes, std::size_t size) noexcept;

  /** Next answer of the receiver, never waits. @return its true size, or 0. */
  std::size_t receive(std::uint8_t* buffer, std::size_t capacity) noexcept;

  /** Own source port. */
  std::uint16_t port() const noexcept { return port_; }

 private:
  FileDescriptor fd_;
  std::uint16_t port_{0};
};

}  // namespace raven2_trainer::net
