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
 * Path of the relayed packets out of the daemon: direct, or through the bad network of a fault of kind `impair`. Each
 * such fault starts its network again from the seed. Packets still in it when the fault ends are sent
 * when they are due; a packet with RelayPacket::is_held discards them. For the sender's thread: it allocates.
 */
class RelayChannel {
 public:
  using Send = std::function<void(const wire::ItpPacket&)>;

  explicit RelayChannel(const LoopConfig& config) : config_(config), seed_(config.library.seed) {}

  /** Bad networks that begin from now on draw from this seed instead of the configuration's. */
  void reseed(std::uint64_t seed) noexcept { seed_ = seed; }

  /** Takes a packet and sends all that are due by now. Call in order of time. */
  void pass(const RelayPacket& packet, std::int64_t now_ns, const Send& send);
  /** Sends packets that have become due. */
  void flush(std::int64_t now_ns, const Send& send);

  /** Since the start: sent = passed + added - lost - held. */
  FaultedPackets counts() const;

 private:
  void begin(std::uint32_t impairment, std::int64_t now_ns);
  void end();

  const LoopConfig config_;
  std::uint64_t seed_;
  std::optional<impair::Channel> channel_;
  FaultedPackets before_{};  ///< of earlier channels
  std::uint64_t cut_{0};     ///< outputs too short to be a packet
  std::uint32_t impairment_{0};
};

}  // namespace raven2_trainer::loop
