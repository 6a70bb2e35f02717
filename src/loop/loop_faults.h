#pragma once

#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/faults/packet_stream.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** Fault injection within the physics loop: on the masters' stream, on the one to the robot, and on what the surgeon
 * feels and sees. One thread; real-time safe. */
class LoopFaults {
 public:
  faults::FaultEngine relay{FaultHost::kRelay}, master{FaultHost::kMaster}, console{FaultHost::kConsole};
  faults::CommandStream relay_stream{FaultVariable::kPacket}, master_stream{FaultVariable::kPacket};

  explicit LoopFaults(SharedState* shared) noexcept : shared_(*shared) {}

  /** Takes a new plan. @param[in] tick it is recorded with. */
  void read(Tick tick) noexcept;
  /** Nothing acts while held; what was kept back of packets is thrown away. */
  void hold(bool is_held) noexcept;
  /** Applies faults to the surgeon's forces and pictures. */
  void corruptConsole(const faults::FaultCycle& cycle, DaemonFaults* state) noexcept;
  /** Writes which faults act in this tick, and their effect on packets. Beginnings and ends since the last tick go to
   * the record: the robot's as they came, and our own. */
  void publish(Tick tick, DaemonFaults* state) noexcept;

 private:
  void publishChanges(Tick tick) noexcept;
  std::array<faults::FaultEngine*, 3> engines() noexcept { return {&relay, &master, &console}; }

  SharedState& shared_;
  std::uint64_t generation_{~std::uint64_t{0}};  ///< of the plan in force
  std::uint64_t unreported_{0};
};

}  // namespace raven2_trainer::loop
