#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/impair/channel.h"
#include "raven2_trainer/impair/impairment.h"

namespace raven2_trainer::proxy {

/** One link through the proxy. */
struct ProxyLink {
  impair::Medium medium{impair::Medium::kDatagrams};
  std::string listen_address{"127.0.0.1"};
  std::uint16_t listen_port{};  ///< 0 takes a free one
  std::string target_host{"127.0.0.1"};
  std::uint16_t target_port{};
  Impairment forward;  ///< what comes in at the listening port
  Impairment back;     ///< what the target answers
};

struct ProxyOptions {
  std::vector<ProxyLink> links;
  std::uint64_t seed{1};
  std::string log;  ///< CSV file of every packet, or none
};

/** Figures of one direction of one link. */
struct ProxyReport {
  std::string link;       ///< "udp 26020", "tcp 26120"
  std::string direction;  ///< "forward", "back"
  impair::ChannelCounts counts{};
  std::uint64_t unsent{};       ///< of the forwarded: the system did not take them
  std::uint64_t connections{};  ///< TCP: made so far
};

/**
 * Works between programs and makes their links bad: UDP in both directions (answers go to the last sender), and TCP.
 * Sockets and a clock around impair::Channel; no thread. The bottleneck, loss and order of packets follow
 * from the seed alone; effects of time follow the real times at which the packets come.
 */
class ImpairmentProxy {
 public:
  /** @throw NetworkException for a host that is unknown or a port that cannot be had, SessionException for a log that
   * cannot be written. */
  explicit ImpairmentProxy(const ProxyOptions& options);
  ~ImpairmentProxy();

  /** Passes packets on until CLOCK_MONOTONIC reaches `until_ns`. */
  void serve(std::int64_t until_ns);

  /** One entry for each direction of each link, in the order of the options. */
  std::vector<ProxyReport> report() const;

  /** Writes what is still held into the log, as held, and closes it. report() stays as it is. @throw SessionException
   * if the log could not be written. */
  void finish();

  /** Listening port of a link. */
  std::uint16_t port(std::size_t link) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::proxy
