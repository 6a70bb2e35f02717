#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "raven2_trainer/wire/itp.h"

// Packets that the daemon's ingest accepts move the desired joints. Input: datagrams of 124 bytes, with a byte before
// each. If the byte is odd, the quaternions are made unit and the increments are cut to the limit first, so that the
// values pass the checks.

namespace raven2_trainer::fuzz {
namespace {

constexpr std::int32_t kMaxIncrementUm = 20000;
constexpr double kMaxRotation = 3.2;  // [rad] any

ArmGeometry geometry() {
  ArmGeometry g;  // config/arms.yaml
  g.d4 = -0.47;
  g.lw = 0.013;
  g.q_min = {0.0, kPi / 4, 0.23, -3.17649923862968, -1.22173047639603, -1.83259571459405, -1.83259571459405};
  g.q_max = {kPi / 2, 3 * kPi / 4, 0.56, 3.17649923862968, 1.22173047639603, 1.83259571459405, 1.83259571459405};
  g.home = {kPi / 6, kPi / 2, 0.4, 0.0, 0.0, kPi / 4, kPi / 4};
  return g;
}

void mend(wire::ItpPacket* packet) {
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    for (auto* d : {&packet->delx_um[arm], &packet->dely_um[arm], &packet->delz_um[arm]})
      *d %= kMaxIncrementUm + 1;
    packet->grasp_mrad[arm] %= 1746;
    const double x = packet->Qx[arm], y = packet->Qy[arm], z = packet->Qz[arm], w = packet->Qw[arm];
    const double norm = std::sqrt(x * x + y * y + z * z + w * w);
    packet->Qx[arm] = x / norm;
    packet->Qy[arm] = y / norm;
    packet->Qz[arm] = z / norm;
    packet->Qw[arm] = w / norm;
  }
}

class Teleop {
 public:
  void take(wire::ItpPacket packet, bool mended) {
    if (mended) mend(&packet);
    if (wire::checkItp(packet, {kMaxIncrementUm, kMaxRotation}) != Reject::kNone) return;
    const MasterCommand command = wire::toCommand(packet);
    for (const Arm arm : kArms)
      apply(command, arm);
  }

 private:
  void apply(const MasterCommand& command, Arm arm) {
    control::TeleopMapper& mapper = at(mappers_, arm);
    if (command.pedal == 0) return mapper.rebasePose(mapper.desired());
    mapper.add(at(command.dp_I, arm), at(command.dq_I, arm), at(command.dgrasp, arm), mapper.desired());
    requireWithinLimits(mapper.desired());
    require(mapper.desiredPose().p.allFinite() && mapper.desiredPose().R.allFinite(), "the desired pose is finite");
  }

  /** As on the robot (raven2.md 2.3) the jaws' mid-line has a limit, not each jaw. At that limit the jaws keep the
   * desired opening, so one of them may be beyond the limit by half of the opening. */
  void requireWithinLimits(const JointArray& q) const {
    constexpr double kMostOpening = 1.571;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double room = j >= kGrasp1 ? kMostOpening / 2 : 1e-9;
      require(q[j] >= geometry_.q_min[j] - room && q[j] <= geometry_.q_max[j] + room,
              "desired joints stay near limits");
    }
    const double opening = kinematics::jawOpening(q);
    require(opening >= -0.175 && opening <= kMostOpening, "the desired opening is within the jaws' range");
  }

  static control::TeleopMapper makeMapper(Arm arm) {
    control::TeleopMapper mapper(geometry(), arm);
    mapper.rebase(geometry().home);
    return mapper;
  }

  ArmGeometry geometry_{geometry()};
  PerArm<control::TeleopMapper> mappers_{{makeMapper(Arm::kGold), makeMapper(Arm::kGreen)}};
};

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  fuzz::Input input(data, size);
  fuzz::Teleop teleop;
  while (!input.empty()) {
    const bool mended = (input.byte() & 1U) != 0;
    const fuzz::Bytes bytes = input.take(wire::kItpSize);
    wire::ItpPacket packet;
    if (wire::decodeItp(bytes.data(), bytes.size(), &packet) == Reject::kNone) teleop.take(packet, mended);
  }
  return 0;
}
