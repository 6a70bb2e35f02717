#include "raven2_trainer/raven/itp_faults.h"

#include <array>
#include <cmath>

#include "raven2_trainer/faults/packet_faults.h"

namespace raven2_trainer::raven {

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

}  // namespace raven2_trainer::raven
