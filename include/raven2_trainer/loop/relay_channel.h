#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/impair/channel.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::loop {

/**
 * Path of the relayed packets out of the daemon: straight, or through the bad network of a fault of kind `impair`. Each
 * time one begins it begins again, from the configuration's seed. Packets that it still holds when the fault ends come
 * when they are due, unless a packet is held clean (RelayPacket::is_held): then it is lost. For the sender's thread: it
 * allocates.
 */
class RelayChannel {
 public:
  using Send = std::function<void(const wire::ItpPacket&)>;

  explicit RelayChannel(const LoopConfig& config) : config_(config) {}

  /** One packet in; whatever comes out by now is sent. Calls in order of time. */
  void pass(const RelayPacket& packet, std::int64_t now_ns, const Send& send);
  /** Sends packets that have become due. */
  void flush(std::int64_t now_ns, const Send& send);

  /** Since the start: given to `send` = passed + added - lost - held. */
  FaultedPackets counts() const;

 private:
  void begin(std::uint32_t impairment, std::int64_t now_ns);
  void end();

  const LoopConfig config_;
  std::optional<impair::Channel> channel_;
  FaultedPackets before_{};  ///< of the channels before this one
  std::uint64_t cut_{0};     ///< came out too short to be a packet
  std::uint32_t impairment_{0};
};

}  // namespace raven2_trainer::loop
