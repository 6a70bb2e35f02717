#include "raven2_trainer/preload/network_faults.h"

#include "preload/plan_rows.h"

namespace raven2_trainer::preload {
NetworkFaults::NetworkFaults(const FaultPlan& plan, CycleHistory* history) : history_(*history) {
  engine_.setPlan(rowsOf(plan, /*of_network=*/true));
}

/** All cycles that the control thread began since the last call, each with its run level. */
void NetworkFaults::catchUp(std::int64_t now_ns) noexcept {
  for (const std::uint64_t begun = history_.begun(); cycles_ < begun;) {
    const std::uint8_t level = history_.runLevel(cycles_);
    ++cycles_;
    engine_.beginCycle({level == kPedalDown, level, {}});
    log_.note(&engine_, cycles_, now_ns, history_.newestCommand());
  }
}

void NetworkFaults::offer(const wire::ItpBytes& bytes, std::int64_t now_ns) noexcept {
  catchUp(now_ns);
  wire::ItpPacket packet;
  wire::decodeItp(bytes.data(), bytes.size(), &packet);  // of the right size, so it succeeds
  history_.countPacket(packet.surgeon_mode != 0, packet.sequence);
  engine_.beginPacket(packet.surgeon_mode != 0);
  log_.note(&engine_, cycles_, now_ns, history_.newestCommand());
  const bool passes = cycles_ == 0 || (!engine_.isArmed() && held_.isEmpty());  // before the first cycle nothing acts
  if (passes) {
    held_.pass(packet);
    untouched_ = bytes;
    has_untouched_ = true;
    return;
  }
  held_.offer(packet, &engine_);
}

bool NetworkFaults::take(wire::ItpBytes* bytes, std::int64_t now_ns) noexcept {
  if (has_untouched_) {
    has_untouched_ = false;
    *bytes = untouched_;
    return true;
  }
  catchUp(now_ns);
  wire::ItpPacket packet;
  if (!held_.take(&packet, engine_)) return false;
  raven::injectFaults(&engine_, &packet);
  *bytes = wire::encodeItp(packet);
  return true;
}

}  // namespace raven2_trainer::preload
