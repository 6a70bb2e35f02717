#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

/** What arrived. */
struct Datagram {
  std::size_t size{};  ///< [bytes] as sent; more than the buffer holds means it was cut, so it is seen, not accepted
  Endpoint source{};
  bool foreign{};  ///< a source is pinned and this is another one
};

/** A bound UDP socket. Non-blocking; after construction it neither throws nor allocates. */
class UdpReceiver {
 public:
  /**
   * @param[in] port 0 takes a free one.
   * @throw NetworkException with address, port and the system's error.
   */
  UdpReceiver(const std::string& bind_address, std::uint16_t port);

  std::uint16_t port() const noexcept { return port_; }

  /** Waits at most `timeout_ms`. @return true if receive() has something. */
  bool wait(int timeout_ms) noexcept;

  /** Next datagram waiting; its first `capacity` bytes are in `buffer`. Never waits. */
  std::optional<Datagram> receive(std::uint8_t* buffer, std::size_t capacity) noexcept;

  /** From now on datagrams of any other address or port are marked foreign. */
  void pinSource(const Endpoint& source) noexcept { pinned_ = source; }
  void unpinSource() noexcept { pinned_.reset(); }
  const std::optional<Endpoint>& pinnedSource() const noexcept { return pinned_; }

  int fd() const noexcept { return fd_.get(); }

 private:
  FileDescriptor fd_;
  std::uint16_t port_{0};
  std::optional<Endpoint> pinned_;
};

}  // namespace raven2_trainer::net
