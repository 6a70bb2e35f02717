#pragma once

#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/wire/itp.h"
#include "unit/plant/dh_raven.h"

namespace raven2_trainer::plant::test {

inline const TrainerConfig& trainerConfig() {
  static const TrainerConfig loaded =
      config::loadTrainerConfig(std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/config/trainer.yaml");
  return loaded;
}

/** With homing `quick`: joints known at power-on. */
inline const VirtualRavenConfig& quickRaven() {
  static const VirtualRavenConfig config = [] {
    VirtualRavenConfig quick = trainerConfig().virtual_raven;
    quick.full_homing = false;
    quick.homing_time = 0.3;
    return quick;
  }();
  return config;
}

/** Control software and plant, one cycle at a time, with a master that sends one packet a cycle. */
class ClosedLoop {
 public:
  explicit ClosedLoop(const ArmsConfig& arms = trainerConfig().arms, const VirtualRavenConfig& robot = quickRaven())
      : geometry(arms.geometry), software(arms, robot), plant(dhRaven(arms), robot) {}

  void cycle() { plant.step(software.cycle(plant.read())); }

  void cycles(int n) {
    for (int k = 0; k < n; ++k)
      cycle();
  }

  /** Runs until the software is in a level; false after `limit` cycles. */
  bool runTo(RunLevel level, int limit = 10000) {
    for (int k = 0; k < limit; ++k) {
      if (software.state().runlevel == level) return true;
      cycle();
    }
    return false;
  }

  /** One packet: pedal, gold and green increments in ITP axes [um]. */
  void send(bool pedal, const std::array<int, 3>& gold = {}, const std::array<int, 3>& green = {}, int grasp_mrad = 0) {
    wire::ItpPacket packet;
    packet.sequence = ++sequence;
    packet.delx_um = {gold[0], green[0]};
    packet.dely_um = {gold[1], green[1]};
    packet.delz_um = {gold[2], green[2]};
    packet.grasp_mrad = {grasp_mrad, grasp_mrad};
    packet.surgeon_mode = pedal ? 1 : 0;
    const wire::ItpBytes bytes = wire::encodeItp(packet);
    software.receive(bytes.data(), bytes.size());
  }

  /** A packet and a cycle, n times. */
  void drive(int n, bool pedal, const std::array<int, 3>& gold = {}, const std::array<int, 3>& green = {}) {
    for (int k = 0; k < n; ++k) {
      send(pedal, gold, green);
      cycle();
    }
  }

  /** Homed and in PEDAL_DN, at rest. */
  bool engage() {
    if (!runTo(RunLevel::kPedalUp)) return false;
    drive(20, true);
    return software.state().runlevel == RunLevel::kPedalDown;
  }

  Vector3 tip(Arm arm) const { return kinematics::forward(geometry, arm, plant.jointPositions(arm)).p; }

  ArmGeometry geometry;
  raven::ControlSoftware software;
  Plant plant;
  std::uint32_t sequence{0};
};

}  // namespace raven2_trainer::plant::test
