#pragma once

#include <array>
#include <optional>
#include <vector>

#include "proxy/impairment_log.h"
#include "raven2_trainer/net/poll_set.h"
#include "raven2_trainer/net/udp_socket.h"
#include "raven2_trainer/proxy/impairment_proxy.h"

namespace raven2_trainer::proxy {

/** One UDP link of the proxy: a listening socket, and one to the target. Answers go to the last sender. */
class UdpBridge {
 public:
  /** @param[in] stream generators of this link: it takes this one and the next. @throw NetworkException. */
  UdpBridge(const ProxyLink& link, std::uint64_t seed, std::uint64_t stream, std::int64_t start_ns, ImpairmentLog* log);

  void watch(net::PollSet* poll) const;
  std::optional<std::int64_t> nextDue() const noexcept;
  void receive();
  void deliver();
  /** Writes what is held into the log. */
  void finish();
  void report(std::vector<ProxyReport>* all) const;
  std::uint16_t port() const noexcept { return front_.port(); }

 private:
  struct Direction {
    std::string name;
    std::string where;  ///< of the log
    impair::Channel channel;
    std::uint64_t unsent{};
  };

  void take(net::UdpSocket* socket, Direction* direction);
  bool send(bool is_forward, const impair::Delivery& packet) noexcept;

  net::UdpSocket front_, back_;
  std::string name_;
  std::array<Direction, 2> directions_;  ///< forward, back
  std::optional<net::Endpoint> sender_;
  std::vector<std::uint8_t> buffer_;
  ImpairmentLog& log_;
};

}  // namespace raven2_trainer::proxy
