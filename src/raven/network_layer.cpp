#include "raven/network_layer.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::raven {
namespace {

std::int32_t toField(double value) noexcept {
  if (std::isnan(value)) return 0;
  return static_cast<std::int32_t>(std::clamp(value, -2147483648.0, 2147483647.0));
}

std::int32_t faulted(faults::FaultEngine* faults, FaultTarget target, Arm arm, int axis, std::int32_t value) noexcept {
  return toField(faults->apply(FaultSite::kNetworkLayer, target, arm, axis, value));
}

/** Faults on the fields as they stand on the wire, before any check (paper, Table 1). */
void injectFaults(faults::FaultEngine* faults, wire::ItpPacket* packet) noexcept {
  for (const Arm arm : kArms) {
    at(packet->delx_um, arm) = faulted(faults, FaultTarget::kIncrement, arm, 0, at(packet->delx_um, arm));
    at(packet->dely_um, arm) = faulted(faults, FaultTarget::kIncrement, arm, 1, at(packet->dely_um, arm));
    at(packet->delz_um, arm) = faulted(faults, FaultTarget::kIncrement, arm, 2, at(packet->delz_um, arm));
  }
  packet->surgeon_mode = faulted(faults, FaultTarget::kPedal, Arm::kGold, 0, packet->surgeon_mode);
}

/** [cycles] */
std::int64_t pedalTimeout(const VirtualRavenConfig& config) noexcept {
  const bool hardened = config.behaviour == "hardened";
  return hardened ? std::llround(config.itp.master_timeout / kTickSeconds) : config.master_timeout;
}

ItpRules hardenedRules(ItpRules rules) noexcept {
  rules.hardened = true;  // whatever the daemon does
  return rules;
}

}  // namespace

NetworkLayer::NetworkLayer(const VirtualRavenConfig& config, const wire::ItpKey* key) noexcept
    : hardened_(config.behaviour == "hardened"),
      gate_(hardenedRules(config.itp), wire::Audience::kRobot, key),
      timeout_(pedalTimeout(config)) {}

Reject NetworkLayer::receive(const wire::Arrival& arrival, faults::FaultEngine* faults) noexcept {
  wire::ItpPacket packet;
  const Reject reason = hardened_ ? judgeHardened(arrival, faults, &packet) : judge(arrival, faults, &packet);
  counts_.count(reason);
  if (reason == Reject::kNone) apply(packet);
  return reason;
}

Reject NetworkLayer::judge(const wire::Arrival& arrival,
                           faults::FaultEngine* faults,
                           wire::ItpPacket* packet) noexcept {
  const Reject size_reason = wire::decodeItp(arrival.bytes, std::min(arrival.size, wire::kItpSize), packet);
  if (size_reason != Reject::kNone) return size_reason;
  injectFaults(faults, packet);
  return rule_.check(packet->sequence);
}

/** Faults behind the gate: they are of this program, not of the network, and a signature is over what was sent. */
Reject NetworkLayer::judgeHardened(const wire::Arrival& arrival,
                                   faults::FaultEngine* faults,
                                   wire::ItpPacket* packet) noexcept {
  const Reject reason = gate_.judge(arrival, packet);
  if (reason == Reject::kNone) injectFaults(faults, packet);
  return reason;
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
  silent_cycles_ = -1;
  for (const Arm arm : kArms)
    at(targets_, arm).addInBase(at(dp_um_base0, arm), at(dq, arm));
}

void NetworkLayer::rebase(const PerArm<const MasterTarget*>& poses) noexcept {
  silent_cycles_ = -1;
  for (const Arm arm : kArms)
    at(targets_, arm).rebase(*at(poses, arm));
}

void NetworkLayer::tick() noexcept {
  if (!pedal_) return;
  if (++silent_cycles_ > timeout_) pedal_ = false;
}

}  // namespace raven2_trainer::raven
