#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

/**
 * A TCP connection that is kept up: connects without blocking and, when it is lost, again after a pause that doubles
 * from `reconnect_min` to `reconnect_max` and starts again once something is received. An attempt that nobody answers
 * is given up after kConnectTimeoutNs. A peer that vanishes without a word is noticed within about 3 s (keep-alive
 * 1/1/3, TCP_USER_TIMEOUT 2 s). After construction nothing throws or allocates.
 */
class TcpClient {
 public:
  /** [ns] Less than the second after which the system asks again: with the longest pause it is how late a network that
   *  heals is found out. */
  static constexpr std::int64_t kConnectTimeoutNs = 400'000'000;

  enum class Event : std::uint8_t {
    kNone,          ///< nothing happened in the time given
    kConnected,     ///< once for each connection, before anything is received from it
    kReadable,      ///< receive() has something to say
    kDisconnected,  ///< once for each connection that was up
  };

  /**
   * Resolves the host; the first attempt is the first poll()'s.
   * @param[in] reconnect_min, reconnect_max [s] 0 < min <= max.
   * @throw NetworkException with host and port if the host is unknown or the pauses are not as above.
   */
  TcpClient(const std::string& host, std::uint16_t port, double reconnect_min, double reconnect_max);

  /** Moves the connection on and waits at most `timeout_ms` for something to happen.
   *  @param[in] now_ns [ns] caller's monotonic time; only the pauses depend on it. */
  Event poll(std::int64_t now_ns, int timeout_ms) noexcept;

  /** Takes bytes that have arrived. @return their number, or 0; the end of the connection is reported by
   * the next poll(). */
  std::size_t receive(std::uint8_t* buffer, std::size_t capacity) noexcept;

  /** All or nothing: a connection that took a part only is given up. @return false if nothing will arrive. */
  bool send(const std::uint8_t* bytes, std::size_t size) noexcept;

  /** Gives the connection up (a broken stream, say); it is made again after the pause. */
  void disconnect() noexcept;

  bool isConnected() const noexcept { return state_ == State::kUp; }
  bool isConnecting() const noexcept { return state_ == State::kConnecting; }
  std::uint64_t attempts() const noexcept { return attempts_; }  ///< connects started so far

 private:
  enum class State : std::uint8_t { kDown, kConnecting, kUp };

  Event pollDown(std::int64_t now_ns, int timeout_ms) noexcept;
  Event pollConnecting(std::int64_t now_ns, int timeout_ms) noexcept;
  Event pollUp(int timeout_ms) noexcept;
  void startConnect(std::int64_t now_ns) noexcept;
  void retryLater(std::int64_t now_ns) noexcept;

  Endpoint peer_;
  std::int64_t pause_min_ns_;
  std::int64_t pause_max_ns_;
  std::int64_t pause_ns_;
  std::int64_t next_attempt_ns_{0};
  std::int64_t give_up_ns_{0};
  bool has_tried_{false};
  bool lost_{false};  ///< kDisconnected is still to be reported
  State state_{State::kDown};
  FileDescriptor fd_;
  std::uint64_t attempts_{0};
};

}  // namespace raven2_trainer::net
