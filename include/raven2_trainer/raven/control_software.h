#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/raven/usb_packets.h"

namespace raven2_trainer::raven {

/**
 * The Raven's control program (`r2_control`), emulated and stepped: network layer with the robot's own sequence rules,
 * state machine, inverse kinematics, cable coupling, PD in motor space, DAC, overdrive check, USB packets, in the
 * order of raven2.md 4.2, with the paper's three injection points. No sockets, threads or clocks.
 * Real-time safe after construction.
 */
class ControlSoftware {
 public:
  ControlSoftware(const ArmsConfig& arms, const VirtualRavenConfig& config);
  ~ControlSoftware();
  ControlSoftware(const ControlSoftware&) = delete;
  ControlSoftware& operator=(const ControlSoftware&) = delete;

  /** A datagram on UDP 36000, as recvfrom gave it. Injection point network_layer is right behind it. */
  void receive(const std::uint8_t* bytes, std::size_t size) noexcept;

  /** Faults to apply from the next cycle on. */
  void setFaults(const FaultPlan& plan) noexcept;

  /** One 1 ms control cycle: boards in, boards out. */
  PerArm<UsbOutBytes> cycle(const PerArm<UsbInBytes>& boards) noexcept;

  /** What the state frame carries after the last cycle: cycle, last_sequence, active_fault, run level, arms' q, dq,
   *  motor, dac, homed, soft_estopped, itp counters. */
  const RobotState& state() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::raven
