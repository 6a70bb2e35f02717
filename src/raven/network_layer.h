#pragma once

#include <cstdint>

#include "raven/master_target.h"
#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/raven/itp_faults.h"
#include "raven2_trainer/raven/virtual_raven_config.h"
#include "raven2_trainer/wire/itp_gate.h"
#include "raven2_trainer/wire/sequence_rule.h"

namespace raven2_trainer::raven {

/** The robot's receiver of ITP packets: fault site network_layer, size, order, accumulation (raven2.md 1.4, 1.5); or,
 *  hardened, what the daemon's own ingest demands in their place. Real-time safe. */
class NetworkLayer {
 public:
  /** @param[in] key of signed ITP, outlives this; may be nullptr. Only a hardened robot verifies. */
  NetworkLayer(const VirtualRavenConfig& config, const wire::ItpKey* key);

  /** One datagram as recvfrom gave it: compat cuts it to 124 bytes if longer; only hardened looks at source and time.
   *  A packet that a fault loses was never received; one that it holds back is received when it comes out. */
  void receive(const wire::Arrival& arrival, faults::FaultEngine* faults) noexcept;
  /** Packets that a fault held back and that are due. Once a cycle. */
  void release(faults::FaultEngine* faults) noexcept;

  /** Hardened with a key: whether this asks for a session; then it is answer()'s. */
  bool isHello(const wire::Arrival& arrival) const noexcept { return hardened_ && gate_.isHello(arrival); }
  /** kNone: send `*reply` to the source, nothing is counted. */
  Reject answer(const wire::Arrival& arrival, const wire::Nonce& fresh, wire::HandshakeBytes* reply) noexcept;

  /** Hardened: lets go of a silent master. Once a cycle. */
  void idle(std::int64_t now_ns) noexcept { gate_.idle(now_ns); }

  /** Once a cycle: the pedal comes up when more than `master_timeout` cycles have passed without an update. Hardened,
   *  only a packet is one. */
  void tick() noexcept;

  /** Increments of /raven_automove: base frame, no sequence, pedal or grasp; an update like a packet. */
  void automove(const PerArm<Vec3>& dp_um_base0, const PerArm<Quat>& dq) noexcept;

  /** Takes the wanted poses of both arms over into the accumulators, which counts as an update. */
  void rebase(const PerArm<const MasterTarget*>& poses) noexcept;

  bool pedal() const noexcept { return pedal_; }
  MasterTarget& target(Arm arm) noexcept { return at(targets_, arm); }
  std::uint32_t lastSequence() const noexcept { return hardened_ ? gate_.last() : rule_.last(); }
  /** Of the last accepted packet, as /ravenstate shows it; 111 before (raven2 local_io.cpp:103). */
  std::uint32_t lastAccepted() const noexcept { return last_accepted_; }
  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  void take(wire::ItpPacket packet, faults::FaultEngine* faults) noexcept;
  void apply(const wire::ItpPacket& packet) noexcept;
  void update() noexcept;

  bool hardened_;
  wire::SequenceRule rule_;
  wire::ItpGate gate_;
  ItpStream held_{FaultVariable::kPacket};
  PerArm<MasterTarget> targets_{};
  LinkCounts counts_{};
  std::int64_t timeout_;
  std::int64_t silent_cycles_{-1};  // since the cycle that saw the last update
  std::uint32_t last_accepted_{111};
  bool pedal_{false};
};

}  // namespace raven2_trainer::raven
