#include "raven2_trainer/loop/relay_channel.h"

#include <utility>

namespace raven2_trainer::loop {
namespace {

constexpr std::uint64_t kStream = 2;  // 0 and 1: directions between console and daemon; 2, too: pictures to the console

}  // namespace

void RelayChannel::pass(const RelayPacket& packet, std::int64_t now_ns, const Send& send) {
  if (packet.is_held != 0) end();
  const bool is_known = packet.impairment <= config_.impairments.size();
  if (packet.impairment != impairment_ && packet.impairment != 0 && is_known) {
    flush(now_ns, send);
    begin(packet.impairment, now_ns);
  }
  impairment_ = packet.impairment;
  if (impairment_ == 0 || !channel_) {
    flush(now_ns, send);
    send(wire::fromCommand(packet.command));
    return;
  }
  const wire::ItpBytes bytes = wire::encodeItp(wire::fromCommand(packet.command));
  channel_->offer(bytes.data(), bytes.size(), now_ns);
  flush(now_ns, send);
}

void RelayChannel::begin(std::uint32_t impairment, std::int64_t now_ns) {
  end();
  channel_.emplace(config_.impairments[impairment - 1], seed_, kStream, now_ns);
}

/** Packets that are still in the channel are lost. */
void RelayChannel::end() {
  before_ = counts();
  before_.lost += std::exchange(before_.held, 0);
  cut_ = 0;
  channel_.reset();
}

FaultedPackets RelayChannel::counts() const {
  FaultedPackets all = before_;
  if (!channel_) return all;
  const impair::ChannelCounts& now = channel_->counts();
  all.lost += now.droppedTotal() + cut_;
  all.added += now.duplicates;
  all.held = now.held;
  return all;
}

void RelayChannel::flush(std::int64_t now_ns, const Send& send) {
  while (channel_) {
    const auto delivery = channel_->take(now_ns);
    if (!delivery) return;
    wire::ItpPacket packet;
    if (wire::decodeItp(delivery->bytes.data(), delivery->bytes.size(), &packet) == Reject::kNone) {
      send(packet);
    } else {
      ++cut_;
    }
  }
}

}  // namespace raven2_trainer::loop
