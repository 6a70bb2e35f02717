#pragma once

#include <cstdint>

#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/preload/change_log.h"
#include "raven2_trainer/preload/cycle_history.h"
#include "raven2_trainer/raven/itp_faults.h"

namespace raven2_trainer::preload {

/**
 * Faults between a control program and its socket: the site network_layer on plain ITP packets as recvfrom gave them,
 * before any check of the program's.
 *
 * For one thread, the program's network thread. Its cycle changes only when a packet comes: a fault still begins in
 * its own cycle, but a packet that is held back comes out with a later call. Real-time safe after construction.
 */
class NetworkFaults {
 public:
  /** @param[in] plan its rows on the boards are left out. @param[in,out] history outlives this. */
  NetworkFaults(const FaultPlan& plan, CycleHistory* history);

  /** A packet has come. @param[in] now_ns [ns] for the log. */
  void offer(const wire::ItpBytes& bytes, std::int64_t now_ns) noexcept;
  /** The next packet for the program: the received bytes without a fault. @return false without a packet. */
  bool take(wire::ItpBytes* bytes, std::int64_t now_ns) noexcept;

  const ChangeLog& log() const noexcept { return log_; }

 private:
  void catchUp(std::int64_t now_ns) noexcept;

  CycleHistory& history_;
  faults::FaultEngine engine_{FaultHost::kRobot};
  ChangeLog log_;
  raven::ItpStream held_{FaultVariable::kPacket};
  wire::ItpBytes untouched_{};
  bool has_untouched_{false};
  std::uint64_t cycles_{0};
};

}  // namespace raven2_trainer::preload
