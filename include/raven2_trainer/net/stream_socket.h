#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

/** One end of a TCP connection as plain bytes, for a program between two others. Never waits, never throws. */
class StreamSocket {
 public:
  enum class Result : std::uint8_t {
    kDone,        ///< `count` bytes moved, at least one
    kWouldBlock,  ///< nothing now
    kEnd,         ///< the peer will send no more
    kError,       ///< the connection is gone
  };
  struct Moved {
    Result result{Result::kWouldBlock};
    std::size_t count{};
  };

  explicit StreamSocket(FileDescriptor fd) noexcept;

  /** Begins to connect; the socket is writable once it has, and send() fails if it could not. */
  static std::optional<StreamSocket> connecting(const Endpoint& peer) noexcept;

  Moved receive(std::uint8_t* buffer, std::size_t capacity) noexcept;
  Moved send(const std::uint8_t* bytes, std::size_t size) noexcept;
  /** Signals the peer that nothing more comes. */
  void endSending() noexcept;

  int fd() const noexcept { return fd_.get(); }

 private:
  FileDescriptor fd_;
};

/** Takes TCP connections. */
class StreamListener {
 public:
  /** Parameters and errors are those of TcpServer. */
  StreamListener(const std::string& address, std::uint16_t port, double patience = kBindPatience);

  std::optional<StreamSocket> accept() noexcept;

  std::uint16_t port() const noexcept { return port_; }
  int fd() const noexcept { return fd_.get(); }

 private:
  FileDescriptor fd_;
  std::uint16_t port_{0};
};

}  // namespace raven2_trainer::net
