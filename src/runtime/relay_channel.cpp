#include "raven2_trainer/runtime/relay_channel.h"

#include <array>
#include <cstring>

namespace raven2_trainer::runtime {
namespace {

constexpr std::uint64_t kStream = 2;  // 0 and 1 are the directions between console and daemon

}  // namespace

void RelayChannel::pass(const RelayPacket& packet, std::int64_t now_ns, const Send& send) {
  const bool is_known = packet.impairment <= config_.impairments.size();
  if (packet.impairment != impairment_ && packet.impairment != 0 && is_known) {
    flush(now_ns, send);
    channel_.emplace(config_.impairments[packet.impairment - 1], config_.seed, kStream, now_ns);
  }
  impairment_ = packet.impairment;
  if (impairment_ == 0 || !channel_) {
    flush(now_ns, send);
    send(packet.command);
    return;
  }
  std::array<std::uint8_t, sizeof(MasterCommand)> bytes;
  std::memcpy(bytes.data(), &packet.command, bytes.size());
  channel_->offer(bytes.data(), bytes.size(), now_ns);
  flush(now_ns, send);
}

void RelayChannel::flush(std::int64_t now_ns, const Send& send) {
  while (channel_) {
    const auto delivery = channel_->take(now_ns);
    if (!delivery) return;
    MasterCommand command;
    if (delivery->bytes.size() != sizeof(command)) continue;  // cut short on its way: no packet
    std::memcpy(static_cast<void*>(&command), delivery->bytes.data(), sizeof(command));
    send(command);
  }
}

}  // namespace raven2_trainer::runtime
