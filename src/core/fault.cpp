#include "raven2_trainer/core/fault_variables.h"

#include <cmath>

namespace raven2_trainer {
namespace {

/** Largest time in a plan: a million hours. An engine's sums of such times stay within int64. */
constexpr std::int64_t kMaxFaultTicks = std::int64_t{1} << 42U;

bool isTime(std::int64_t ticks) noexcept {
  return ticks >= 0 && ticks <= kMaxFaultTicks;
}

bool isWithin(double value, double low, double high) noexcept {
  return value >= low && value <= high;  // false for NaN
}

bool isAddressed(const Fault& fault) noexcept {
  if (static_cast<std::size_t>(fault.variable) >= kFaultVariableCount || fault.arm < -1 || fault.channel < -1)
    return false;
  const auto channels = static_cast<int>(channelsOf(fault.variable).count);
  return infoOf(fault.variable).site == fault.site && fault.arm < static_cast<int>(kArmCount) &&
         fault.channel < channels;
}

bool areTimesSound(const Fault& fault) noexcept {
  return fault.first_tick >= -kMaxFaultTicks && fault.first_tick <= kMaxFaultTicks && isTime(fault.duration_ticks) &&
         isTime(fault.period_ticks) && fault.count >= 0 && isTime(fault.half_period_ticks) && isTime(fault.ramp_ticks);
}

/** The limits of a scenario file: twice 1e308 would be infinite, and stay so in a filter. */
bool areNumbersSound(const Fault& fault) noexcept {
  if (!isWithin(fault.threshold, 0.0, 1e6) || !isWithin(fault.probability, 0.0, 1.0) || !std::isfinite(fault.value) ||
      !std::isfinite(fault.low) || !std::isfinite(fault.high))
    return false;
  if (!isNumberKind(fault.kind)) return true;
  if (fault.kind == FaultKind::kScale) return isWithin(fault.value, -kMaxFaultFactor, kMaxFaultFactor);
  const FaultVariableInfo& info = infoOf(fault.variable);
  if (fault.kind == FaultKind::kRandom || fault.kind == FaultKind::kRandomOnce)
    return isWithin(fault.low, info.low, fault.high) && isWithin(fault.high, fault.low, info.high);
  const bool has_value = fault.kind != FaultKind::kSignFlip && fault.kind != FaultKind::kHoldLast;
  return !has_value || isWithin(fault.value, info.low, info.high);
}

/** A stream's fault must fit into the stream. */
bool isStreamSound(const Fault& fault) noexcept {
  switch (fault.kind) {
    case FaultKind::kDrop:
      return isWithin(fault.value, 0.0, 1.0);
    case FaultKind::kDelay:
      return isWithin(fault.low, 0.0, kMaxStreamDelay) && isWithin(fault.high, fault.low, kMaxStreamDelay);
    case FaultKind::kDuplicate:
      return isWithin(fault.value, 1.0, kMaxDuplicates);
    case FaultKind::kReorder:
      return isWithin(fault.value, 2.0, kMaxReordered);
    case FaultKind::kReplay:
      return isWithin(fault.value, 1.0, kMaxStreamDelay);
    case FaultKind::kForge:
      return isWithin(std::abs(fault.low), 0.0, kMaxForgedAhead) &&
             isWithin(fault.value, -2147483648.0, 2147483647.0) && fault.channel >= 0;
    case FaultKind::kImpair:
      return isWithin(fault.value, 0.0, 1000.0) && fault.host == FaultHost::kRelay;
    default:
      return true;
  }
}

bool takesFrame(FaultKind kind) noexcept {
  return kind == FaultKind::kDrop || kind == FaultKind::kDelay || kind == FaultKind::kDuplicate ||
         kind == FaultKind::kHoldLast;
}

}  // namespace

bool takes(FaultVariable variable, FaultKind kind) noexcept {
  switch (variable) {
    case FaultVariable::kNone:
      return false;
    case FaultVariable::kProgram:
      return kind == FaultKind::kCrash || kind == FaultKind::kHang;
    case FaultVariable::kFrame:
      return takesFrame(kind);
    case FaultVariable::kPacket:
      return isStreamKind(kind) || kind == FaultKind::kHoldLast;
    default:
      return isNumberKind(kind);
  }
}

bool isSound(const Fault& fault) noexcept {
  const bool is_known = static_cast<std::size_t>(fault.host) < kFaultHostCount &&
                        static_cast<std::size_t>(fault.kind) < kFaultKindCount &&
                        static_cast<std::size_t>(fault.trigger) < kFaultTriggerCount && fault.row < kMaxFaults;
  return is_known && isAddressed(fault) && serves(fault.host, fault.site) && takes(fault.variable, fault.kind) &&
         areTimesSound(fault) && areNumbersSound(fault) && isStreamSound(fault);
}

}  // namespace raven2_trainer
