#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/detector/anomaly_detector.h"
#include "raven2_trainer/detector/detector_config.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/raven/raven_report.h"
#include "raven2_trainer/raven/usb_packets.h"
#include "raven2_trainer/raven/virtual_raven_config.h"
#include "raven2_trainer/wire/itp_session.h"

namespace raven2_trainer::raven {

/** Findings and actions of the detector since the start. */
struct DetectorReport {
  std::uint64_t alarms{};        ///< times it was raised
  std::uint64_t cycles_acted{};  ///< in which a command was replaced or the robot stopped
  detector::Verdict verdict{};   ///< of the last cycle
};

/**
 * The Raven's control program (`r2_control`), emulated and stepped. It has the network layer with the robot's own
 * sequence rules, state machine, inverse kinematics, cable coupling, PD in motor space, DAC, overdrive check and USB
 * packets, in the order of raven2.md 4.2. Each of its functions has an injection point (core/fault_variables.h). No
 * sockets, threads or clocks. Real-time safe after construction.
 */
class ControlSoftware {
 public:
  /** @param[in] key of signed ITP, outlives this; nullptr: nothing is verified. Only `hardened` verifies.
   *  @throw ConfigException for an unknown `behaviour`. */
  ControlSoftware(const ArmsConfig& arms, const VirtualRavenConfig& config, const wire::ItpKey* key = nullptr);
  ~ControlSoftware();
  ControlSoftware(const ControlSoftware&) = delete;
  ControlSoftware& operator=(const ControlSoftware&) = delete;

  /** A datagram on UDP 36000, as recvfrom gave it. Injection point network_layer is right behind it. */
  void receive(const std::uint8_t* bytes, std::size_t size) noexcept { receive(bytes, size, 0); }
  /** `source` names address and port, for `hardened`. */
  void receive(const std::uint8_t* bytes, std::size_t size, std::uint64_t source) noexcept;

  /** The same with an answer to a request for a session of signed ITP. @param[in] fresh random, used at most once.
   *  @return true: send `*reply` to the source. */
  bool receive(const std::uint8_t* bytes,
               std::size_t size,
               std::uint64_t source,
               const wire::Nonce& fresh,
               wire::HandshakeBytes* reply) noexcept;

  /** Faults to apply from the next cycle on. */
  void setFaults(const FaultPlan& plan) noexcept;

  /** Sets the detector on guard behind put_USB_packet, unless `mitigate` is off: then nothing is changed. Before the
   *  first cycle. @throw ConfigException as CableCoupling. */
  void setDetector(const DetectorConfig& detector);

  /** Nothing but zeros without a detector. */
  DetectorReport detectorReport() const noexcept;

  /** The oldest unreported beginning or end of a fault, with this cycle. Ask after each cycle, until @return false. */
  bool nextFaultChange(FaultChange* change) noexcept;

  /** Signals for fault triggers, from the next cycle on. */
  void setSignals(const FaultSignals& signals) noexcept;

  /** false from the cycle in which a fault crashed or hung the program: it does nothing any more, the boards keep
   *  their last commands. state().program says which; one last state goes out, with the fault that did it. */
  bool isAlive() const noexcept;

  /** Homed and in PEDAL_UP, both arms exactly at home where the boards' counts are 0. Before the first cycle. */
  void startAtHome() noexcept;

  /** One message of /raven_automove: increments in the arms' base frames [um], truncated, and quaternions (x y z w),
   *  left-multiplied; no axis map, pedal, grasp or sequence (raven2.md 5.3). Counts as an update for the time-out. */
  void automove(const PerArm<Vec3>& dp_um_base0, const PerArm<Quat>& dq) noexcept;

  /** One 1 ms control cycle: boards in, boards out. A board whose read failed keeps its old counts and pins. */
  PerArm<UsbOutBytes> cycle(const PerArm<UsbRead>& boards) noexcept;

  /** The same with reads that succeed. */
  PerArm<UsbOutBytes> cycle(const PerArm<UsbInBytes>& boards) noexcept;

  /** Data of the state frame after the last cycle: cycle, last_sequence, active_fault, run level, arms' q, dq,
   *  motor, dac, homed, soft_estopped, itp counters, fault_mask; program says whether it still runs. */
  const RobotState& state() const noexcept;

  /** The state as it is sent to the daemon: one goes in behind each cycle, as many come out as faults let.
   *  @param[in] time_ns [ns] clock of the robot's computer in that cycle. */
  void returnState(std::int64_t time_ns) noexcept;
  bool nextReturned(RobotState* state) noexcept;

  /** The robot's /ravenstate message after the last cycle. */
  const RavenReport& report() const noexcept;

  /** Reads that gave an error or too few bytes, both boards. */
  std::uint64_t usbReadErrors() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::raven
