#include "daemon/sender.h"

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::daemon {

Sender::Sender(const TrainerConfig& config, const wire::ItpKey* key, SharedState* shared)
    : to_robot_(config.network.robot_host,
                config.network.robot_port,
                wire::Audience::kRobot,
                key,
                net::ItpSender::Unanswered::kPlain),
      to_console_(config.network.console_host, config.network.force_port),
      channel_(config),
      shared_(*shared) {}

void Sender::tick() noexcept {
  const std::int64_t now_ns = net::monotonicNow();
  const auto send = [this](const wire::ItpPacket& sent) { sendRelay(sent); };
  RelayPacket packet;
  while (shared_.relay_packets.tryPop(&packet))
    channel_.pass(packet, now_ns, send);
  channel_.flush(now_ns, send);
  shared_.relay_network.store(channel_.counts());
  while (shared_.force_packets.tryPop(&last_force_))
    sendForce(last_force_);
}

void Sender::sendSilence() noexcept {
  last_force_.force_I = {};
  ++last_force_.sequence;
  shared_.force_silent.add();
  sendForce(last_force_);
}

void Sender::releasePedal() noexcept {
  if (last_sent_.surgeon_mode == 0) return;  // not what was given out: a fault's bad network may still hold the rest
  MasterCommand release;
  release.sequence = last_sent_.sequence + 1;  // in order for the robot, which drops what comes behind a gap
  shared_.relay_released.add();
  sendRelay(wire::fromCommand(release));
}

void Sender::sendRelay(const wire::ItpPacket& packet) noexcept {
  const bool taken = to_robot_.send(packet, net::monotonicNow());
  last_sent_ = packet;
  (taken ? shared_.relay_sent : shared_.relay_failed).add();
}

void Sender::sendForce(const ForcePacket& force) noexcept {
  const wire::ForceBytes bytes = wire::encodeForce(force);
  const bool taken = to_console_.send(bytes.data(), bytes.size());
  (taken ? shared_.force_sent : shared_.force_failed).add();
}

}  // namespace raven2_trainer::daemon
