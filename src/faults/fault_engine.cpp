#include "raven2_trainer/faults/fault_engine.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::faults {
namespace {

bool isSame(const Fault& a, const Fault& b) noexcept {
  return a.id == b.id && a.host == b.host && a.variable == b.variable && a.kind == b.kind && a.trigger == b.trigger &&
         a.arm == b.arm && a.channel == b.channel && a.first_tick == b.first_tick && a.value == b.value &&
         a.low == b.low && a.high == b.high && a.seed == b.seed && a.row == b.row && a.arming == b.arming;
}

bool isDue(const Fault& fault, std::int64_t next, std::int64_t times, std::int64_t clock) noexcept {
  const bool exhausted = fault.period_ticks == 0 ? times > 0 : (fault.count > 0 && times >= fault.count);
  return !exhausted && clock >= next;
}

/** Has what the trigger waits for come about? */
bool hasCome(const Fault& fault, const FaultCycle& cycle, std::uint32_t tool_changes) noexcept {
  switch (fault.trigger) {
    case FaultTrigger::kHand:
      return true;
    case FaultTrigger::kRunLevel:
      return cycle.run_level == fault.threshold;
    case FaultTrigger::kTissueDistance:
      return cycle.signals.tissue_distance <= fault.threshold;
    case FaultTrigger::kTargetDistance:
      return cycle.signals.target_distance <= fault.threshold;
    case FaultTrigger::kStep:
      return cycle.signals.step >= fault.threshold;
    case FaultTrigger::kToolChange:
      return cycle.signals.tool_changes != tool_changes;
    default:
      return false;
  }
}

/** A fault of a pedal-down or of a step of the exercise waits until the pedal is down. */
bool waitsForPedal(FaultTrigger trigger) noexcept {
  return trigger == FaultTrigger::kPedalDown || trigger == FaultTrigger::kStep;
}

double share(const Fault& fault, std::int64_t elapsed) noexcept {
  return elapsed + 1 >= fault.ramp_ticks ? 1.0
                                         : static_cast<double>(elapsed + 1) / static_cast<double>(fault.ramp_ticks);
}

}  // namespace

void FaultEngine::start(const Fault& fault, Progress* progress) const noexcept {
  *progress = Progress{};
  progress->next = fault.first_tick;
  // Rows of one scenario share its seed: their variable and arm distinguish them.
  progress->random = Random(fault.seed, (static_cast<std::uint64_t>(fault.variable) << 16U) +
                                            (static_cast<std::uint64_t>(fault.arm + 1) << 8U) +
                                            static_cast<std::uint64_t>(fault.channel + 1));
}

void FaultEngine::setPlan(const FaultPlan& plan) noexcept {
  if (!kHasHooks || plan.generation == plan_.generation) return;
  plan_.generation = plan.generation;
  plan_.is_suspended = plan.is_suspended;
  if (plan.is_suspended == 0) takeOver(plan);
  rearm();
}

void FaultEngine::hold(bool is_held) noexcept {
  if (is_held == held_) return;
  held_ = is_held;
  rearm();
}

void FaultEngine::takeOver(const FaultPlan& plan) noexcept {
  const bool is_same_session = plan.session == plan_.session;
  if (!is_same_session) tick_ = packet_ = -1;
  const FaultPlan old = plan_;
  const auto former = progress_;
  std::array<bool, kMaxFaults> goes_on{};
  plan_ = plan;
  plan_.count = std::min<std::uint32_t>(plan.count, kMaxFaults);
  variables_ = 0;
  const auto* end = old.faults.begin() + (is_same_session ? old.count : 0);
  for (std::size_t i = 0; i < plan_.count; ++i) {
    const Fault& fault = plan_.faults[i];
    if (fault.host == host_) variables_ |= std::uint64_t{1} << static_cast<unsigned>(fault.variable);
    const auto* same = std::find_if(old.faults.begin(), end, [&](const Fault& f) { return isSame(f, fault); });
    if (same == end) {
      start(fault, &progress_[i]);
      continue;
    }
    const auto was = static_cast<std::size_t>(same - old.faults.begin());
    progress_[i] = former[was];
    goes_on[was] = true;
  }
  for (std::size_t i = 0; armed_ && i < old.count; ++i) {
    if (former[i].active && !goes_on[i]) report(old.faults[i], old.session, false);
  }
}

/** Whether anything may act; what was acting when that changes is reported. */
void FaultEngine::rearm() noexcept {
  const Fault* const rows = plan_.faults.data();
  const bool has_any = std::any_of(rows, rows + plan_.count, [this](const Fault& f) { return f.host == host_; });
  const bool arms = has_any && !held_ && plan_.is_suspended == 0;
  if (arms == armed_) return;
  armed_ = arms;
  for (std::size_t i = 0; i < plan_.count; ++i) {
    if (progress_[i].active) report(plan_.faults[i], plan_.session, arms);
    for (Element& element : progress_[i].elements) {
      element.seen = false;  // values of before are of no account now
      element.of = -1;
    }
  }
}

void FaultEngine::report(const Fault& fault, std::uint32_t session, bool acts) noexcept {
  if (fault.host != host_) return;
  ++number_;
  if (changes_begun_ - changes_published_ == kMaxChanges) return;
  FaultChange change;
  change.number = number_;
  change.session = session;
  change.id = fault.id;
  change.host = host_;
  change.row = fault.row;
  change.acts = acts ? 1 : 0;
  changes_[changes_begun_ % kMaxChanges] = change;
  ++changes_begun_;
}

bool FaultEngine::nextChange(FaultChange* change) noexcept {
  if (changes_published_ == changes_begun_) return false;
  *change = changes_[changes_published_ % kMaxChanges];
  ++changes_published_;
  return true;
}

void FaultEngine::beginCycle(const FaultCycle& cycle) noexcept {
  ++cycle_;
  if (tick_ >= 0 || cycle.pedal_down) ++tick_;
  for (std::size_t i = 0; kHasHooks && i < plan_.count; ++i) {
    const Fault& fault = plan_.faults[i];
    Progress& progress = progress_[i];
    if (fault.host != host_) continue;
    if (!progress.looked_at) progress.tool_changes = cycle.signals.tool_changes;
    progress.looked_at = true;
    if (lastsForPackets(fault)) continue;
    progress.clock = clockOf(fault, progress, cycle);
    advance(fault, &progress, cycle.pedal_down || !waitsForPedal(fault.trigger));
  }
}

void FaultEngine::beginPacket(bool pedal_down) noexcept {
  if (packet_ >= 0 || pedal_down) ++packet_;
  for (std::size_t i = 0; kHasHooks && i < plan_.count; ++i) {
    const Fault& fault = plan_.faults[i];
    if (fault.host != host_ || !lastsForPackets(fault)) continue;
    progress_[i].clock = packet_;
    advance(fault, &progress_[i], true);
  }
}

std::int64_t FaultEngine::clockOf(const Fault& fault,
                                  const Progress& progress,
                                  const FaultCycle& cycle) const noexcept {
  if (fault.trigger == FaultTrigger::kPedalDown) return tick_;
  if (fault.trigger == FaultTrigger::kPowerOn) return cycle_;
  if (fault.trigger == FaultTrigger::kPacket) return packet_;
  if (progress.clock >= 0) return progress.clock + 1;
  return hasCome(fault, cycle, progress.tool_changes) ? 0 : -1;
}

void FaultEngine::advance(const Fault& fault, Progress* progress, bool may_start) noexcept {
  const std::int64_t clock = progress->clock;
  if (clock < 0) return;
  if (progress->active && ++progress->age >= fault.duration_ticks && fault.duration_ticks > 0) end(fault, progress);
  if (progress->active || !isDue(fault, progress->next, progress->times, clock) || !may_start) return;
  ++progress->times;
  // Armed late, the periods that have passed are not made up for.
  if (fault.period_ticks != 0) {
    const std::int64_t passed = (clock - progress->next) / fault.period_ticks;
    progress->next += (passed + 1) * fault.period_ticks;
  }
  if (fault.probability < 1.0 && progress->random.uniform(0.0, 1.0) >= fault.probability) return;
  progress->active = true;
  progress->age = 0;
  ++progress->activations;
  if (armed_) report(fault, plan_.session, true);
}

/** One that began late and ran over its next time does not come again at once. */
void FaultEngine::end(const Fault& fault, Progress* progress) noexcept {
  progress->active = false;
  const std::int64_t missed = progress->clock - progress->next;
  if (fault.period_ticks > 0 && missed > 0)
    progress->next += (missed + fault.period_ticks - 1) / fault.period_ticks * fault.period_ticks;
  if (armed_) report(fault, plan_.session, false);
}

bool FaultEngine::concerns(const Fault& fault, FaultVariable variable, Arm arm, std::size_t channel) const noexcept {
  return fault.host == host_ && fault.variable == variable &&
         (fault.arm < 0 || static_cast<std::size_t>(fault.arm) == index(arm)) &&
         (fault.channel < 0 || static_cast<std::size_t>(fault.channel) == channel);
}

bool FaultEngine::isActing(const Fault& fault, const Progress& progress) const noexcept {
  if (!progress.active) return false;
  if (fault.half_period_ticks == 0) return true;
  return progress.age / fault.half_period_ticks % 2 == 0;
}

double FaultEngine::corrupt(FaultVariable variable, Arm arm, std::size_t channel, double value) noexcept {
  for (std::size_t i = 0; i < plan_.count; ++i) {
    const Fault& fault = plan_.faults[i];
    if (!isNumberKind(fault.kind) || !concerns(fault, variable, arm, channel)) continue;
    Progress& progress = progress_[i];
    Element& element = progress.elements[index(arm) * kMaxFaultChannels + channel];
    if (!progress.active) {
      element.last = value;
      element.seen = true;
      continue;
    }
    if (element.of != progress.activations) {
      element.of = progress.activations;
      element.onset = value;
      if (fault.kind == FaultKind::kRandomOnce && element.drawn_of != progress.activations) {
        element.drawn = progress.random.uniform(fault.low, fault.high);
        element.drawn_of = progress.activations;
      }
      if (!element.seen) element.last = value;
    }
    if (isActing(fault, progress)) value = corrupted(fault, &progress, element, value);
  }
  return value;
}

double FaultEngine::corrupted(const Fault& fault, Progress* progress, const Element& element, double value) noexcept {
  switch (fault.kind) {
    case FaultKind::kStuckAt:
      return fault.value;
    case FaultKind::kAdd:
      return value + fault.value;
    case FaultKind::kAddAndHold:
      return element.onset + fault.value;
    case FaultKind::kScale:
      return value * fault.value;
    case FaultKind::kSignFlip:
      return -value;
    case FaultKind::kRamp:
      return element.onset + (fault.value - element.onset) * share(fault, progress->age);
    case FaultKind::kDrift:
      return value + fault.value * share(fault, progress->age);
    case FaultKind::kRandom:
      return progress->random.uniform(fault.low, fault.high);
    case FaultKind::kRandomOnce:
      return element.drawn;
    case FaultKind::kHoldLast:
      return element.last;
    default:
      return value;
  }
}

std::int32_t FaultEngine::applyInt(FaultVariable variable, Arm arm, std::size_t channel, std::int32_t value) noexcept {
  if (!hasRow(variable)) return value;
  const double faulted = corrupt(variable, arm, channel, value);
  if (std::isnan(faulted)) return 0;
  return static_cast<std::int32_t>(std::lround(std::clamp(faulted, -2147483648.0, 2147483647.0)));
}

const Fault* FaultEngine::acting(FaultVariable variable, FaultKind kind) const noexcept {
  if (!isArmed()) return nullptr;
  for (std::size_t i = 0; i < plan_.count; ++i) {
    const Fault& fault = plan_.faults[i];
    if (fault.host == host_ && fault.variable == variable && fault.kind == kind && isActing(fault, progress_[i]))
      return &fault;
  }
  return nullptr;
}

double FaultEngine::draw(const Fault& fault) noexcept {
  return progress_[static_cast<std::size_t>(&fault - plan_.faults.data())].random.uniform(0.0, 1.0);
}

std::uint8_t FaultEngine::activeMask() const noexcept {
  unsigned mask = 0;
  for (std::size_t i = 0; isArmed() && i < plan_.count; ++i) {
    if (plan_.faults[i].host == host_ && progress_[i].active) mask |= 1U << i;
  }
  return static_cast<std::uint8_t>(mask);
}

std::uint32_t FaultEngine::activeId() const noexcept {
  const unsigned mask = activeMask();
  for (std::size_t i = 0; mask != 0 && i < plan_.count; ++i) {
    if ((mask >> i & 1U) != 0) return plan_.faults[i].id;
  }
  return 0;
}

}  // namespace raven2_trainer::faults
