#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/endpoint.h"
#include "raven2_trainer/net/file_descriptor.h"

namespace raven2_trainer::net {

/**
 * Sends frames to a few readers and takes bytes from them, without a thread of its own: the owner calls poll().
 * Every reader has a bounded queue of whole frames. A reader too slow for it loses the oldest ones; it never delays
 * the sender or another reader; one that takes no byte at all for kStallNs is closed. Neither send nor poll raises
 * SIGPIPE.
 */
class TcpServer {
 public:
  static constexpr std::size_t kMaxClients = 4;
  static constexpr std::size_t kQueueFrames = 32;
  static constexpr std::int64_t kStallNs = 2'000'000'000;  ///< [ns] as TCP_USER_TIMEOUT (reliability.md 2.2, rule 11)

  /** Names one connection; never used again. */
  using ClientId = std::uint64_t;

  /** Told by poll(), in the caller's thread. Each may call send(), broadcast() and drop(). */
  class Listener {
   public:
    virtual ~Listener() = default;
    virtual void onConnect(ClientId client) = 0;
    virtual void onBytes(ClientId client, const std::uint8_t* bytes, std::size_t size) = 0;
    /** The connection is gone: closed by the reader, lost, stalled, or dropped. reader() still knows it. */
    virtual void onDisconnect(ClientId client) = 0;
  };

  /**
   * @param[in] port 0 takes a free one.
   * @throw NetworkException with address, port and the system's error.
   */
  TcpServer(const std::string& bind_address, std::uint16_t port);
  ~TcpServer();
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  std::uint16_t port() const noexcept { return port_; }

  /** Accepts, receives and sends what can be without waiting; first waits at most `timeout_ms` for any of it. The work
   *  of one call is bounded, however much the readers send.
   *  @param[in] now_ns [ns] monotonic; only the time of a stall is measured with it. */
  void poll(int timeout_ms, Listener& listener, std::int64_t now_ns = monotonicNow());

  /** Queues a frame of at most wire::kMaxFrame bytes and sends what the socket takes at once. @return false if there
   *  is no such client or the frame is too large. No allocation. */
  bool send(ClientId client, const std::uint8_t* frame, std::size_t size) noexcept;

  /** send() to every client. @return number of clients. */
  std::size_t broadcast(const std::uint8_t* frame, std::size_t size) noexcept;

  /** Closes a connection at the next poll(). */
  void drop(ClientId client) noexcept;

  /** One connection, for reports. */
  struct ReaderInfo {
    Endpoint peer;
    std::uint64_t frames_sent{};     ///< queued for it, the dropped ones included
    std::uint64_t frames_dropped{};  ///< of these, lost because it was too slow
    bool stalled{};                  ///< closed for kStallNs without a byte taken
  };
  /** All zero if there is no such client. */
  ReaderInfo reader(ClientId client) const noexcept;

  std::size_t clientCount() const noexcept;
  std::uint64_t framesDropped() const noexcept { return frames_dropped_; }    ///< lost by slow readers, in all
  std::uint64_t clientsRefused() const noexcept { return clients_refused_; }  ///< came when kMaxClients were here

 private:
  struct Client;

  void acceptAll(Listener& listener);
  void admit(FileDescriptor fd, const Endpoint& peer, Listener& listener);
  void receiveFrom(Client& client, Listener& listener);
  void enqueue(Client& client, const std::uint8_t* frame, std::size_t size) noexcept;
  static void flush(Client& client) noexcept;
  void reap(Listener& listener);
  void closeStalled(std::int64_t now_ns) noexcept;

  FileDescriptor listening_;
  std::uint16_t port_{0};
  std::array<std::unique_ptr<Client>, kMaxClients> clients_;
  ClientId next_id_{1};
  std::uint64_t frames_dropped_{0};
  std::uint64_t clients_refused_{0};
};

}  // namespace raven2_trainer::net
