#include "loop/loop_faults.h"

#include <algorithm>

namespace raven2_trainer::loop {

void LoopFaults::read(Tick tick) noexcept {
  FaultPlan plan;
  if (!shared_.faults.tryLoad(&plan)) return;
  for (faults::FaultEngine* engine : engines())
    engine->setPlan(plan);
  if (plan.generation == generation_) return;
  generation_ = plan.generation;
  shared_.fault_records.tryPush({tick, plan});
}

void LoopFaults::hold(bool is_held) noexcept {
  for (faults::FaultEngine* engine : engines())
    engine->hold(is_held);
  if (!is_held) return;
  master_stream.clear();  // what a fault held back of a virtual robot's is not for a real one
  relay_stream.clear();
}

void LoopFaults::corruptConsole(const faults::FaultCycle& cycle, DaemonFaults* state) noexcept {
  console.beginCycle(cycle);
  state->console = console.activeMask();
  for (const Arm arm : kArms) {
    at(state->force_gain, arm) = console.apply(FaultVariable::kForceGain, arm, 0, 1.0);
    at(state->force_offset_B, arm) = Vec3{};
    console.applyAll(FaultVariable::kForceOffset, arm, &at(state->force_offset_B, arm));
  }
  const std::int32_t picture = console.applyInt(FaultVariable::kPicture, Arm::kGold, 0, 0);
  const std::int32_t delay = console.applyInt(FaultVariable::kPictureDelay, Arm::kGold, 0, 0);
  constexpr auto kLast = static_cast<std::int32_t>(kPictureFaultCount) - 1;
  state->picture = static_cast<std::uint8_t>(std::clamp(picture, 0, kLast));
  state->picture_delay_ms = static_cast<std::uint32_t>(std::clamp(delay, 0, 5000));
}

void LoopFaults::publish(Tick tick, DaemonFaults* state) noexcept {
  state->relay = relay.activeMask();
  state->master = master.activeMask();
  state->active = 0;
  for (const faults::FaultEngine* engine : engines()) {
    if (state->active == 0) state->active = engine->activeId();
  }
  publishChanges(tick);
  shared_.master_faults.store(master_stream.counts());
  shared_.relay_faults.store(relay_stream.counts());
}

void LoopFaults::publishChanges(Tick tick) noexcept {
  FaultChange change;
  while (shared_.fault_changes.tryPop(&change))
    shared_.change_records.tryPush({tick, change});
  std::uint64_t unreported = 0;
  for (faults::FaultEngine* engine : engines()) {
    while (engine->nextChange(&change)) {
      change.cycle = static_cast<std::uint64_t>(tick);
      shared_.change_records.tryPush({tick, change});
    }
    unreported += engine->changesUnreported();
  }
  if (unreported > unreported_) shared_.fault_changes_unreported.add(unreported - unreported_);
  unreported_ = unreported;
}

}  // namespace raven2_trainer::loop
