#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

/** A received datagram. */
struct Datagram {
  std::size_t size{};  ///< [bytes] UdpReceiver: as sent, also if the buffer holds fewer; UdpSocket: those in the buffer
  Endpoint source{};
  bool foreign{};  ///< a source is pinned and this is another one
};

/**
 * A bound UDP socket. Non-blocking; after construction it neither throws nor allocates.
 *
 * Pinned to a source, the socket is connected to it: the kernel then hands over nothing else, so that a flood from
 * elsewhere costs this process nothing. Packets of others go to a second, small socket on the same port, from which
 * receiveForeign() takes samples; the rest is dropped there.
 */
class UdpReceiver {
 public:
  /**
   * @param[in] port 0 takes a free one.
   * @param[in] patience [s] it is tried again for so long while another program has the port.
   * @throw NetworkException with address, port and the system's error; of a taken port, who has it.
   */
  UdpReceiver(const std::string& bind_address, std::uint16_t port, double patience = kBindPatience);

  std::uint16_t port() const noexcept { return port_; }

  /** Waits at most `timeout_ms`; what is foreign does not end it. @return true if receive() has something. */
  bool wait(int timeout_ms) noexcept;

  /** Next datagram waiting; its first `capacity` bytes are in `buffer`. Never waits. */
  std::optional<Datagram> receive(std::uint8_t* buffer, std::size_t capacity) noexcept;

  /** The same of those that came from elsewhere while a source is pinned. */
  std::optional<Datagram> receiveForeign(std::uint8_t* buffer, std::size_t capacity) noexcept;

  /** Answers a datagram. @return false if the system did not take it. */
  bool sendTo(const Endpoint& to, const std::uint8_t* bytes, std::size_t size) noexcept;

  /** From now on only this address and port are heard; what is queued already is marked if it is foreign. */
  void pinSource(const Endpoint& source) noexcept;
  void unpinSource() noexcept;
  const std::optional<Endpoint>& pinnedSource() const noexcept { return pinned_; }

  int fd() const noexcept { return fd_.get(); }

 private:
  int bindBoth(Endpoint endpoint) noexcept;
  std::optional<Datagram> receiveFrom(const FileDescriptor& fd, std::uint8_t* buffer, std::size_t capacity) noexcept;

  FileDescriptor guard_;  ///< bound first, so that the kernel prefers the other one
  FileDescriptor fd_;
  std::uint16_t port_{0};
  std::optional<Endpoint> pinned_;
};

}  // namespace raven2_trainer::net
