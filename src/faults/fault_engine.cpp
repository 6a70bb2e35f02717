#include "raven2_trainer/faults/fault_engine.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::faults {
namespace {

bool isSame(const Fault& a, const Fault& b) noexcept {
  return a.id == b.id && a.site == b.site && a.first_tick == b.first_tick && a.value == b.value;
}

bool isDue(const Fault& fault, std::int64_t next, std::int64_t times, std::int64_t tick) noexcept {
  const bool exhausted = fault.period_ticks == 0 ? times > 0 : (fault.count > 0 && times >= fault.count);
  return !exhausted && tick >= next;
}

std::size_t channel(Arm arm, int joint) noexcept {
  return index(arm) * kJointCount + static_cast<std::size_t>(joint);
}

/** Nearest int32, saturated; NaN, such as infinity times 0, gives 0. */
std::int32_t roundToInt(double value) noexcept {
  if (std::isnan(value)) return 0;
  return static_cast<std::int32_t>(std::lround(std::clamp(value, -2147483648.0, 2147483647.0)));
}

}  // namespace

void FaultEngine::setPlan(const FaultPlan& plan) noexcept {
  if (plan.generation == plan_.generation) return;
  std::array<Progress, kMaxFaults> progress{};
  for (std::size_t i = 0; i < std::min<std::size_t>(plan.count, kMaxFaults); ++i) {
    progress[i].next = plan.faults[i].first_tick;
    for (std::size_t k = 0; k < plan_.count; ++k) {
      if (isSame(plan.faults[i], plan_.faults[k])) progress[i] = progress_[k];
    }
  }
  plan_ = plan;
  plan_.count = std::min<std::uint32_t>(plan.count, kMaxFaults);
  progress_ = progress;
}

void FaultEngine::beginCycle(bool pedal_down) noexcept {
  if (tick_ >= 0 || pedal_down) ++tick_;
  if (tick_ < 0) return;
  for (std::size_t i = 0; i < plan_.count; ++i) {
    if (plan_.faults[i].host == host_) advance(plan_.faults[i], &progress_[i], pedal_down);
  }
}

void FaultEngine::advance(const Fault& fault, Progress* progress, bool pedal_down) const noexcept {
  if (progress->active && tick_ >= progress->end) progress->active = false;
  if (progress->active || !isDue(fault, progress->next, progress->times, tick_) || !pedal_down) return;
  progress->active = true;
  progress->end = tick_ + fault.duration_ticks;
  ++progress->times;
  // Armed late, the periods that have passed are not made up for.
  if (fault.period_ticks == 0) return;
  const std::int64_t passed = (tick_ - progress->next) / fault.period_ticks;
  progress->next += (passed + 1) * fault.period_ticks;
}

bool FaultEngine::concerns(const Fault& fault, FaultSite site, FaultTarget target, Arm arm, int joint) const noexcept {
  return fault.host == host_ && fault.site == site && fault.target == target &&
         (fault.arm < 0 || static_cast<std::size_t>(fault.arm) == index(arm)) &&
         (fault.joint < 0 || fault.joint == joint);
}

double FaultEngine::apply(FaultSite site, FaultTarget target, Arm arm, int joint, double value) noexcept {
  for (std::size_t i = 0; i < plan_.count; ++i) {
    const Fault& fault = plan_.faults[i];
    if (!concerns(fault, site, target, arm, joint)) continue;
    double& held = progress_[i].held[channel(arm, joint)];
    if (!progress_[i].active) {
      held = value;
      continue;
    }
    switch (fault.kind) {
      case FaultKind::kStuckAt:
        value = fault.value;
        break;
      case FaultKind::kAdd:
        value += fault.value;
        break;
      case FaultKind::kScale:
        value *= fault.value;
        break;
      case FaultKind::kHoldLast:
        value = held;
        break;
      case FaultKind::kNone:
        break;
    }
  }
  return value;
}

void FaultEngine::applyToCommand(MasterCommand* command) noexcept {
  if (plan_.count == 0) return;
  for (const Arm arm : kArms) {
    Vec3& dp = at(command->dp_I, arm);
    for (int axis = 0; axis < 3; ++axis) {
      double& component = dp[static_cast<std::size_t>(axis)];
      const double um = apply(FaultSite::kNetworkLayer, FaultTarget::kIncrement, arm, axis, component * 1e6);
      component = static_cast<double>(roundToInt(um)) * 1e-6;
    }
  }
  const double pedal = apply(FaultSite::kNetworkLayer, FaultTarget::kPedal, Arm::kGold, 0, command->pedal);
  command->pedal = pedal != 0.0 ? 1 : 0;
}

std::uint32_t FaultEngine::activeId() const noexcept {
  for (std::size_t i = 0; i < plan_.count; ++i) {
    if (plan_.faults[i].host == host_ && progress_[i].active) return plan_.faults[i].id;
  }
  return 0;
}

}  // namespace raven2_trainer::faults
