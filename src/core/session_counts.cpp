#include "raven2_trainer/core/record.h"

namespace raven2_trainer {
namespace {

struct Sum {
  const char* meaning;
  bool holds;
};

template <std::size_t N>
const char* firstWrong(const std::array<Sum, N>& sums) noexcept {
  for (const Sum& sum : sums) {
    if (!sum.holds) return sum.meaning;
  }
  return nullptr;
}

const char* wrongLink(const SessionCounts& c) noexcept {
  const RingCounts& commands = ring(c, RingId::kMasterCommands);
  const RingCounts& relay = ring(c, RingId::kRelayPackets);
  const RingCounts& forces = ring(c, RingId::kForcePackets);
  const std::uint64_t full = c.master.rejected[static_cast<std::size_t>(Reject::kQueueFull)];
  return firstWrong(std::array<Sum, 9>{{
      {"master to daemon: received = applied + rejected", c.master.addsUp()},
      {"robot to daemon: received = applied + rejected", c.robot_state.addsUp()},
      {"daemon to robot: received = applied + rejected, as the robot counted", c.relay.addsUp()},
      {"master to daemon: applied = commands queued", c.master.applied == commands.pushed},
      {"master to daemon: rejected for a full queue = commands dropped", full == commands.dropped},
      {"master to daemon: used <= commands taken - overruled + made of clients' + added by faults",
       c.master_used + c.master_overruled <= commands.taken + c.servo_made + c.master_faults.added},
      {"daemon to robot: sent + failed + lost + held = packets taken + released + added",
       c.relay_sent + c.relay_failed + c.relay_network.lost + c.relay_network.held ==
           relay.taken + c.relay_released + c.relay_network.added},
      {"daemon to console: sent + failed = packets taken + silent ones",
       c.force_sent + c.force_failed == forces.taken + c.force_silent},
      {"packets to robot and console: none waits", relay.pushed == relay.taken && forces.pushed == forces.taken},
  }});
}

const char* wrongRecord(const SessionCounts& c) noexcept {
  std::uint64_t dropped = 0;
  for (std::size_t i = static_cast<std::size_t>(RingId::kTickRecords); i < kRingCount; ++i) {
    if (c.rings[i].pushed != c.rings[i].taken) return "records: none waits to be written";
    dropped += c.rings[i].dropped;
  }
  return firstWrong(std::array<Sum, 4>{{
      {"records: dropped = sum over their rings", c.records_dropped == dropped},
      {"commands taken + made of clients' = overruled + their records",
       ring(c, RingId::kMasterCommands).taken + c.servo_made ==
           c.master_overruled + ring(c, RingId::kCommandRecords).offered()},
      {"requests and pedals' taken + made of clients' forces = their records",
       ring(c, RingId::kRequests).taken + ring(c, RingId::kPedalRequests).taken + c.efforts_made ==
           ring(c, RingId::kRequestRecords).offered()},
      {"plans taken <= their records", ring(c, RingId::kPlanResults).taken <= ring(c, RingId::kPlanRecords).offered()},
  }});
}

/** Lockstep has no loops to time. */
const char* wrongLoop(const SessionCounts& c) noexcept {
  if (c.lockstep != 0) return nullptr;
  const LoopTiming& physics = c.loops[static_cast<std::size_t>(LoopId::kPhysics)];
  const LoopTiming& haptic = c.loops[static_cast<std::size_t>(LoopId::kHaptic)];
  return firstWrong(std::array<Sum, 4>{{
      {"physics loop: ticks = on time + late", physics.ticks == physics.on_time + physics.slips},
      {"haptic loop: ticks = on time + late", haptic.ticks == haptic.on_time + haptic.slips},
      {"physics loop: ticks = their records", physics.ticks == ring(c, RingId::kTickRecords).offered()},
      {"haptic loop: ticks = their records", haptic.ticks == ring(c, RingId::kHapticRecords).offered()},
  }});
}

}  // namespace

const char* wrongSum(const SessionCounts& counts) noexcept {
  for (const RingCounts& ring : counts.rings) {
    if (ring.taken > ring.pushed) return "a ring gave out more than went in";
  }
  const char* wrong = wrongLink(counts);
  if (wrong == nullptr) wrong = wrongRecord(counts);
  return wrong != nullptr ? wrong : wrongLoop(counts);
}

}  // namespace raven2_trainer
