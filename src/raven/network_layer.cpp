#include "raven/network_layer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "raven2_trainer/faults/packet_faults.h"

namespace raven2_trainer::raven {
namespace {

/** Faults on the fields as they stand on the wire, before any check (paper, Table 1). */
void injectFaults(faults::FaultEngine* faults, wire::ItpPacket* packet) noexcept {
  if (!faults->isArmed()) return;
  for (const Arm arm : kArms) {
    const auto um = faults::faultedIncrement(
        faults, arm, {at(packet->delx_um, arm), at(packet->dely_um, arm), at(packet->delz_um, arm)});
    at(packet->delx_um, arm) = um[0];
    at(packet->dely_um, arm) = um[1];
    at(packet->delz_um, arm) = um[2];
    const Quat q = faults::faultedRotation(
        faults, arm, {at(packet->Qx, arm), at(packet->Qy, arm), at(packet->Qz, arm), at(packet->Qw, arm)});
    at(packet->Qx, arm) = q[0];
    at(packet->Qy, arm) = q[1];
    at(packet->Qz, arm) = q[2];
    at(packet->Qw, arm) = q[3];
    at(packet->grasp_mrad, arm) = faults->applyInt(FaultVariable::kGrasp, arm, 0, at(packet->grasp_mrad, arm));
  }
  packet->surgeon_mode = faults->applyInt(FaultVariable::kPedal, Arm::kGold, 0, packet->surgeon_mode);
  packet->sequence = faults::faultedSequence(faults, packet->sequence);
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

void ItpTraits::takeMotion(wire::ItpPacket* to, const wire::ItpPacket& from) noexcept {
  const std::uint32_t sequence = to->sequence;
  *to = from;
  to->sequence = sequence;
}

void ItpTraits::forge(wire::ItpPacket* packet, Arm arm, std::size_t axis, double um) noexcept {
  const std::array<PerArm<std::int32_t>*, 3> axes{&packet->delx_um, &packet->dely_um, &packet->delz_um};
  at(*axes[axis], arm) = static_cast<std::int32_t>(std::lround(um));
  packet->surgeon_mode = 1;
}

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
