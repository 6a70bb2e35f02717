#include "raven/network_layer.h"

#include <algorithm>

#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::raven {
namespace {

/** [cycles] */
std::int64_t pedalTimeout(const VirtualRavenConfig& config) noexcept {
  const bool hardened = config.behaviour == "hardened";
  return hardened ? toTicks(config.itp.master_timeout) : config.master_timeout;
}

ItpRules hardenedRules(ItpRules rules) noexcept {
  rules.hardened = true;  // whatever the daemon does
  return rules;
}

}  // namespace

NetworkLayer::NetworkLayer(const VirtualRavenConfig& config, const wire::ItpKey* key)
    : hardened_(config.behaviour == "hardened"),
      gate_(hardenedRules(config.itp), wire::Audience::kRobot, key),
      timeout_(pedalTimeout(config)) {}

/** Hardened, faults are behind the gate: they are of this program, not of the network, and a signature is over what was
 *  sent. In compat they are before the order of the packets is looked at. */
void NetworkLayer::receive(const wire::Arrival& arrival, faults::FaultEngine* faults) noexcept {
  wire::ItpPacket packet;
  const Reject reason = hardened_ ? gate_.judge(arrival, &packet)
                                  : wire::decodeItp(arrival.bytes, std::min(arrival.size, wire::kItpSize), &packet);
  if (reason != Reject::kNone) {
    counts_.count(reason);
    return;
  }
  faults->beginPacket(packet.surgeon_mode != 0);
  if (!faults->isArmed() && held_.isEmpty()) {
    held_.pass(packet);
    return take(packet, faults);
  }
  held_.offer(packet, faults);
  release(faults);
}

void NetworkLayer::release(faults::FaultEngine* faults) noexcept {
  wire::ItpPacket packet;
  while (held_.take(&packet, *faults))
    take(packet, faults);
}

void NetworkLayer::take(wire::ItpPacket packet, faults::FaultEngine* faults) noexcept {
  injectFaults(faults, &packet);
  const Reject reason = hardened_ ? Reject::kNone : rule_.check(packet.sequence);
  counts_.count(reason);
  if (reason == Reject::kNone) apply(packet);
}

Reject NetworkLayer::answer(const wire::Arrival& arrival,
                            const wire::Nonce& fresh,
                            wire::HandshakeBytes* reply) noexcept {
  const Reject reason = gate_.answer(arrival, fresh, reply);
  if (reason != Reject::kNone) counts_.count(reason);
  return reason;
}

void NetworkLayer::apply(const wire::ItpPacket& packet) noexcept {
  pedal_ = packet.surgeon_mode != 0;
  last_accepted_ = packet.sequence;
  silent_cycles_ = -1;
  for (const Arm arm : kArms)
    at(targets_, arm).add(arm, packet);
}

void NetworkLayer::automove(const PerArm<Vec3>& dp_um_base0, const PerArm<Quat>& dq) noexcept {
  update();
  for (const Arm arm : kArms)
    at(targets_, arm).addInBase(at(dp_um_base0, arm), at(dq, arm));
}

void NetworkLayer::rebase(const PerArm<const MasterTarget*>& poses) noexcept {
  update();
  for (const Arm arm : kArms)
    at(targets_, arm).rebase(*at(poses, arm));
}

/** Of a Raven's own time-out. Hardened, only the master's packets say that somebody holds the pedal. */
void NetworkLayer::update() noexcept {
  if (!hardened_) silent_cycles_ = -1;
}

void NetworkLayer::tick() noexcept {
  if (!pedal_) return;
  if (++silent_cycles_ > timeout_) pedal_ = false;
}

}  // namespace raven2_trainer::raven
