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

/** Counts of the frames for one reader, or for all. Invariant: pushed == sent + dropped + unsent + queued. */
struct FrameTotals {
  std::uint64_t pushed{};   ///< given to send() and broadcast()
  std::uint64_t sent{};     ///< handed to the system, whole
  std::uint64_t dropped{};  ///< lost because the reader was too slow
  std::uint64_t unsent{};   ///< still waiting when its connection ended
  std::uint64_t queued{};   ///< waiting, or sent in part

  constexpr bool addsUp() const noexcept { return pushed == sent + dropped + unsent + queued; }
};

/**
 * Sends frames to a few readers and takes bytes from them, without its own thread: the owner calls poll().
 * Every reader has a bounded queue of whole frames. A slow reader loses the oldest frames, and delays neither the
 * sender nor another reader. If frames wait and it takes no byte for kStallNs, it is closed. Neither send nor poll
 * raises SIGPIPE.
 *
 * If all places are taken, a newcomer replaces the oldest reader that sent half a message (markPart()), else the oldest
 * whose frames have waited for kYieldNs, else the newcomer is closed. At most kAdmitBurst newcomers enter at once, then
 * one every kAdmitIntervalNs; others are closed. One that has already left does not count.
 */
class TcpServer {
 public:
  static constexpr std::size_t kMaxClients = 4;
  static constexpr std::size_t kQueueFrames = 32;
  static constexpr std::int64_t kStallNs = 2'000'000'000;  ///< [ns] as TCP_USER_TIMEOUT (sources.md 2.2)
  static constexpr std::int64_t kYieldNs = 250'000'000;  ///< [ns] frames that wait so long may cost a reader its place.
  // At ten a second, a good reader would wait for seconds behind many newcomers; a hundred, of some
  // 50 us each, cost the robot's computer half a percent of a core.
  static constexpr std::int64_t kAdmitIntervalNs = 10'000'000;
  static constexpr std::int64_t kAdmitBurst = 100;

  /** Names one connection; never used again. */
  using ClientId = std::uint64_t;

  /** Called by poll(), in the caller's thread. Each may call send(), broadcast() and drop(). */
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
   * @param[in] patience [s] how long it is tried again while another program has the port.
   * @throw NetworkException with address, port and the system's error; for a taken port, who has it.
   */
  TcpServer(const std::string& bind_address, std::uint16_t port, double patience = kBindPatience);
  ~TcpServer();
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  std::uint16_t port() const noexcept { return port_; }

  /** Accepts, receives and sends what can be without waiting; first waits at most `timeout_ms` for any of it. The work
   *  of one call is bounded, however much the readers send.
   *  @param[in] now_ns [ns] monotonic; stalls and the rate of newcomers are measured with it. */
  void poll(int timeout_ms, Listener& listener, std::int64_t now_ns = monotonicNow());

  /** Queues a frame of at most wire::kMaxFrame bytes and sends what the socket takes at once. @return false if there
   *  is no such client or the frame is too large. No allocation. */
  bool send(ClientId client, const std::uint8_t* frame, std::size_t size) noexcept;

  /** send() to every client. @return number of clients. */
  std::size_t broadcast(const std::uint8_t* frame, std::size_t size) noexcept;

  /** Closes a connection at the next poll(). */
  void drop(ClientId client) noexcept;

  /** Sets whether a message of this reader is incomplete. Such a reader loses its place first. */
  void markPart(ClientId client, bool has_part) noexcept;

  /** One connection, for reports. */
  struct ReaderInfo {
    Endpoint peer;
    FrameTotals frames;
    bool stalled{};  ///< closed because it took no byte for kStallNs
  };
  /** All zero if there is no such client. */
  ReaderInfo reader(ClientId client) const noexcept;

  std::size_t clientCount() const noexcept;
  FrameTotals totals() const noexcept;  ///< of all readers, here or gone
  std::uint64_t framesDropped() const noexcept { return totals().dropped; }
  std::uint64_t clientsRefused() const noexcept {
    return clients_refused_;
  }  ///< no place for them, or too many at once
  std::uint64_t clientsEvicted() const noexcept { return clients_evicted_; }  ///< lost their place to a newcomer

 private:
  struct Client;

  void acceptAll(Listener& listener);
  void admit(FileDescriptor fd, const Endpoint& peer, Listener& listener);
  bool takeTurn() noexcept;
  void evict(std::unique_ptr<Client>* place, Listener& listener);
  std::unique_ptr<Client>* findPlace() noexcept;
  int readiness(const Client* client) const noexcept;
  void receiveFrom(Client& client, Listener& listener);
  static void enqueue(Client& client, const std::uint8_t* frame, std::size_t size) noexcept;
  static void flush(Client& client) noexcept;
  void reap(Listener& listener);
  void close(std::unique_ptr<Client>* place, Listener& listener);
  void closeStalled() noexcept;

  FileDescriptor listening_;
  std::uint16_t port_{0};
  std::array<std::unique_ptr<Client>, kMaxClients> clients_;
  ClientId next_id_{1};
  std::int64_t now_ns_{0};        // of this poll
  std::int64_t next_turn_ns_{0};  // when newcomers at kAdmitIntervalNs each would all have been admitted
  FrameTotals gone_;              // of readers that have left
  std::uint64_t clients_refused_{0};
  std::uint64_t clients_evicted_{0};
};

}  // namespace raven2_trainer::net
