#pragma once

#include <cstddef>
#include <cstdint>

#include "raven/master_target.h"
#include "raven/sequence_rule.h"
#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/faults/fault_engine.h"

namespace raven2_trainer::raven {

/** The robot's receiver of ITP packets: fault site network_layer, size, order, accumulation (raven2.md 1.4, 1.5).
 *  Real-time safe. */
class NetworkLayer {
 public:
  explicit NetworkLayer(std::int64_t master_timeout) noexcept : timeout_(master_timeout) {}

  /** One datagram as recvfrom gave it: cut to 124 bytes if longer. */
  Reject receive(const std::uint8_t* bytes, std::size_t size, faults::FaultEngine* faults) noexcept;

  /** Once a cycle: the pedal comes up when more than `master_timeout` cycles have passed without an update. */
  void tick() noexcept;

  /** Increments of /raven_automove: base frame, no sequence, pedal or grasp; an update like a packet. */
  void automove(const PerArm<Vec3>& dp_um_base0, const PerArm<Quat>& dq) noexcept;

  /** Takes the wanted poses of both arms over into the accumulators, which counts as an update. */
  void rebase(const PerArm<const MasterTarget*>& poses) noexcept;

  bool pedal() const noexcept { return pedal_; }
  MasterTarget& target(Arm arm) noexcept { return at(targets_, arm); }
  std::uint32_t lastSequence() const noexcept { return rule_.last(); }
  /** Of the last accepted packet, as /ravenstate shows it; 111 before (raven2 local_io.cpp:103). */
  std::uint32_t lastAccepted() const noexcept { return last_accepted_; }
  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  Reject judge(const std::uint8_t* bytes,
               std::size_t size,
               faults::FaultEngine* faults,
               wire::ItpPacket* packet) noexcept;
  void apply(const wire::ItpPacket& packet) noexcept;

  SequenceRule rule_;
  PerArm<MasterTarget> targets_{};
  LinkCounts counts_{};
  std::int64_t timeout_;
  std::int64_t silent_cycles_{-1};  // since the cycle that saw the last update
  std::uint32_t last_accepted_{111};
  bool pedal_{false};
};

}  // namespace raven2_trainer::raven
