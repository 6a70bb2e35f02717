#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "proxy/impairment_log.h"
#include "raven2_trainer/net/poll_set.h"
#include "raven2_trainer/net/stream_socket.h"
#include "raven2_trainer/proxy/impairment_proxy.h"

namespace raven2_trainer::proxy {

/** One TCP link of the proxy: every connection that comes in makes one to the target. */
class TcpBridge {
 public:
  /** Connections at once: the state server has four readers, and a fifth must be refused by it, not here. */
  static constexpr std::size_t kMaxConnections = 16;

  /** @param[in] stream generators of this link: it takes kStreams from this one on. @throw NetworkException. */
  TcpBridge(const ProxyLink& link, std::uint64_t seed, std::uint64_t stream, std::int64_t start_ns, ImpairmentLog* log);
  static constexpr std::uint64_t kStreams = 1U << 20U;  ///< two a connection, for half a million connections

  void watch(net::PollSet* poll) const;
  std::optional<std::int64_t> nextDue() const noexcept;
  void receive();
  void deliver();
  void finish();
  void report(std::vector<ProxyReport>* all) const;
  std::uint16_t port() const noexcept { return listener_.port(); }

 private:
  /** One way of one connection. */
  struct Way {
    impair::Channel channel;
    std::vector<std::uint8_t> out;  ///< left the channel, not yet taken by the system
    std::size_t sent{0};            ///< of these, taken
    bool ended{false};              ///< the source sends no more
    bool end_reported{false};
  };
  struct Connection {
    std::array<net::StreamSocket, 2> sockets;  ///< client, target
    std::array<Way, 2> ways;                   ///< from the client, from the target
    bool broken{false};
  };

  void acceptAll();
  void receiveFrom(Connection* connection, std::size_t side);
  void deliverTo(Connection* connection, std::size_t side);
  void flush(Connection* connection, std::size_t side);
  bool mayRead(const Connection& connection, std::size_t side) const noexcept;
  void reap();
  void close(std::size_t side, impair::Channel* channel);

  const ProxyLink link_;
  const std::uint64_t seed_, stream_;
  const std::int64_t start_ns_;
  const net::Endpoint target_;
  net::StreamListener listener_;
  std::string name_;
  std::array<std::string, 2> where_;
  std::vector<std::unique_ptr<Connection>> connections_;
  std::array<impair::ChannelCounts, 2> closed_{};  ///< of the connections that are over
  std::array<std::uint64_t, 2> unsent_{};          ///< [pieces] held when their connection broke
  std::uint64_t accepted_{0};
  std::vector<std::uint8_t> buffer_;
  ImpairmentLog& log_;
};

}  // namespace raven2_trainer::proxy
