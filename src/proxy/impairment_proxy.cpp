#include "raven2_trainer/proxy/impairment_proxy.h"

#include <algorithm>
#include <variant>

#include "proxy/tcp_bridge.h"
#include "proxy/udp_bridge.h"
#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::proxy {

struct ImpairmentProxy::Impl {
  using Bridge = std::variant<std::unique_ptr<UdpBridge>, std::unique_ptr<TcpBridge>>;

  explicit Impl(const ProxyOptions& options) : start_ns(net::monotonicNow()), log(options.log, start_ns) {
    std::uint64_t stream = 0;
    for (const ProxyLink& link : options.links) {
      if (link.medium == impair::Medium::kDatagrams) {
        bridges.emplace_back(std::make_unique<UdpBridge>(link, options.seed, stream, start_ns, &log));
      } else {
        bridges.emplace_back(std::make_unique<TcpBridge>(link, options.seed, stream, start_ns, &log));
      }
      stream += TcpBridge::kStreams;
    }
  }

  template <typename Call>
  void each(Call call) const {
    for (const Bridge& bridge : bridges)
      std::visit([&](const auto& b) { call(*b); }, bridge);
  }

  void wait(std::int64_t until_ns) {
    poll.clear();
    each([&](const auto& bridge) {
      bridge.watch(&poll);
      if (const auto due = bridge.nextDue()) until_ns = std::min(until_ns, *due);
    });
    poll.wait(until_ns);
  }

  const std::int64_t start_ns;
  ImpairmentLog log;
  std::vector<Bridge> bridges;
  net::PollSet poll;
};

ImpairmentProxy::ImpairmentProxy(const ProxyOptions& options) : impl_(std::make_unique<Impl>(options)) {}

ImpairmentProxy::~ImpairmentProxy() = default;

void ImpairmentProxy::serve(std::int64_t until_ns) {
  do {
    impl_->wait(until_ns);
    impl_->each([](auto& bridge) {
      bridge.receive();
      bridge.deliver();
    });
  } while (net::monotonicNow() < until_ns);
  impl_->log.flush();
}

std::vector<ProxyReport> ImpairmentProxy::report() const {
  std::vector<ProxyReport> all;
  impl_->each([&](const auto& bridge) { bridge.report(&all); });
  return all;
}

void ImpairmentProxy::finish() {
  impl_->each([](auto& bridge) { bridge.finish(); });
  impl_->log.close();
}

std::uint16_t ImpairmentProxy::port(std::size_t link) const {
  return std::visit([](const auto& bridge) { return bridge->port(); }, impl_->bridges.at(link));
}

}  // namespace raven2_trainer::proxy
