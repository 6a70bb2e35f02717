#pragma once

#include <memory>

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/raven/usb_packets.h"
#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::plant {

/**
 * The hardware under the emulated control software: USB boards, PLC, amplifiers, motors, cables, links, encoders of
 * both arms. DAC counts in, encoder counts out. Deterministic; real-time safe after construction.
 */
class Plant {
 public:
  /**
   * Starts at config.start_offset from home, in E-STOP, brakes on, with the start button pressed once.
   * @throw ModelException if an arm's joints do not form the chain of the robot.
   */
  Plant(const model::RavenModel& raven, const VirtualRavenConfig& config);
  ~Plant();
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  /** The boards' packets at the start of a cycle. Encoders count from 0 at power-on. */
  PerArm<raven::UsbInBytes> read() const noexcept;

  /** 1 ms under these board commands: PLC, brakes, motors, links. */
  void step(const PerArm<raven::UsbOutBytes>& out) noexcept;

  /** The start button: leaves E-STOP as soon as the watchdog is alive. An E-STOP lasts until this is called. */
  void pressStart() noexcept;

  /** PEDAL_UP, as if homing had just ended at the arms' places. Before the first step. */
  void startInPedalUp() noexcept;

  /** Level the PLC holds now; the software sees it a few cycles later. */
  RunLevel runLevel() const noexcept;

  /** True joint positions, for tests. [rad; m] */
  JointArray jointPositions(Arm arm) const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::plant
