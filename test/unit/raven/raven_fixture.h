#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::raven::test {

inline const TrainerConfig& trainerConfig() {
  static const TrainerConfig loaded =
      config::loadTrainerConfig(std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/config/trainer.yaml");
  return loaded;
}

inline VirtualRavenConfig quickHoming() {
  VirtualRavenConfig config = trainerConfig().virtual_raven;
  config.homing_time = 0.1;
  config.full_homing = false;
  config.start_offset = JointArray{};
  return config;
}

/** The control software in front of boards whose motors are where the test puts them. */
class Bench {
 public:
  explicit Bench(const VirtualRavenConfig& config = quickHoming())
      : arms(trainerConfig().arms),
        software(arms, config),
        couplings{CableCoupling(Arm::kGold, config), CableCoupling(Arm::kGreen, config)} {
    q = {arms.geometry.home, arms.geometry.home};  // at power-on; counts are relative to it
  }

  UsbOut cycle() {
    PerArm<UsbInBytes> boards;
    for (const Arm arm : kArms)
      at(boards, arm) = encodeIn(board(arm));
    const PerArm<UsbOutBytes> bytes = software.cycle(boards);
    for (const Arm arm : kArms)
      EXPECT_TRUE(decodeOut(at(bytes, arm), &at(out, arm)));
    return out[0];
  }

  void cycles(int n) {
    for (int k = 0; k < n; ++k)
      cycle();
  }

  /** Homed and at `level`; in PEDAL_DN with the pedal pressed. */
  void bringTo(RunLevel level) {
    plc = RunLevel::kInit;
    cycles(1000);
    plc = RunLevel::kPedalUp;
    cycles(10);
    if (level == RunLevel::kPedalDown) engage();
  }

  void engage() {
    send();
    plc = RunLevel::kPedalDown;
    cycles(10);
  }

  Reject send() { return send(next()); }

  Reject send(const wire::ItpPacket& packet) {
    const LinkCounts before = software.state().itp;
    const wire::ItpBytes bytes = wire::encodeItp(packet);
    software.receive(bytes.data(), bytes.size());
    for (std::size_t r = 0; r < kRejectCount; ++r) {
      if (software.state().itp.rejected[r] != before.rejected[r]) return static_cast<Reject>(r);
    }
    return Reject::kNone;
  }

  wire::ItpPacket next() {
    wire::ItpPacket packet;
    packet.sequence = ++sequence;
    packet.surgeon_mode = 1;
    return packet;
  }

  RunLevel level() const { return software.state().runlevel; }

  ArmsConfig arms;
  ControlSoftware software;
  PerArm<CableCoupling> couplings;
  PerArm<JointArray> q;
  PerArm<UsbOut> out{};
  RunLevel plc{RunLevel::kEStop};
  std::uint32_t sequence{0};

 private:
  UsbIn board(Arm arm) const {
    UsbIn in;
    in.pins = static_cast<std::uint8_t>(static_cast<unsigned>(plc) << pins::kLevelShift);
    const JointArray motor = at(couplings, arm).toMotor(at(q, arm));
    const JointArray power_on = at(couplings, arm).toMotor(arms.geometry.home);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      in.encoder[channelOf(j)] =
          encoderSign(arm, j) * static_cast<std::int32_t>(std::lround((motor[j] - power_on[j]) / kMotorRadPerCount));
    }
    return in;
  }
};

}  // namespace raven2_trainer::raven::test
