#include "raven2_trainer/campaign/outcome.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/vec3.h"

namespace raven2_trainer::campaign {
namespace {

Vec3 difference(const Vec3& a, const Vec3& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

bool isFinite(const Vec3& p) noexcept {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/** The robot follows the surgeon where both say so. */
bool isTeleoperated(const Sample& sample) noexcept {
  return sample.plc == RunLevel::kPedalDown && sample.software == RunLevel::kPedalDown;
}

/** The golden run got to PEDAL_DN and this one never, nor did an arm move by itself: it homed at most. */
bool didNotStart(const Figures& figures, const Limits& limits) noexcept {
  if (figures.golden_started == 0 || figures.started != 0) return false;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    if (figures.motion[arm] > figures.golden_motion[arm] + limits.masked) return false;
  }
  return true;
}

/** Some arm stayed where it was while its golden one moved, and no arm moved that did not move as its golden one. */
bool didNotMove(const Figures& figures, const Limits& limits) noexcept {
  bool missed = false;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    const bool stayed = figures.motion[arm] <= limits.still;
    if (!stayed && figures.deviation[arm] > limits.masked) return false;
    missed = missed || (stayed && figures.golden_motion[arm] >= limits.moved);
  }
  return missed;
}

}  // namespace

void Comparison::add(const Sample& golden, const Sample& faulty) noexcept {
  figures_.program = faulty.program;
  watchStart(golden, faulty);
  if (figures_.injected == kNever) begin(golden, faulty);
  if (figures_.injected != kNever) {
    compareTips(golden, faulty);
    watchForce(golden, faulty);
    watchStops(faulty);
  }
  plc_left_ = plc_left_ || faulty.plc != RunLevel::kEStop;
  ++ticks_;
}

void Comparison::watchStart(const Sample& golden, const Sample& faulty) noexcept {
  if (isTeleoperated(golden)) figures_.golden_started = 1;
  if (isTeleoperated(faulty)) figures_.started = 1;
}

/** The tips to measure motion from are those of the tick before. A program that ended reported no fault of its last
 * cycle.
 */
void Comparison::begin(const Sample& golden, const Sample& faulty) noexcept {
  if (faulty.faulted != 0 || faulty.program != ProgramState::kRunning) {
    figures_.injected = ticks_;
  }
  if (figures_.injected == kNever || ticks_ == 0) {
    start_golden_ = golden;
    start_faulty_ = faulty;
  }
}

void Comparison::compareTips(const Sample& golden, const Sample& faulty) noexcept {
  Deviation deviation{};
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    if (!isFinite(faulty.p_BT[arm])) {
      figures_.is_finite = 0;
      return;
    }
    deviation[arm] = difference(faulty.p_BT[arm], golden.p_BT[arm]);
    const auto farther = [](double so_far, const Vec3& a, const Vec3& b) { return std::max(so_far, distance(a, b)); };
    figures_.deviation[arm] = farther(figures_.deviation[arm], faulty.p_BT[arm], golden.p_BT[arm]);
    figures_.motion[arm] = farther(figures_.motion[arm], faulty.p_BT[arm], start_faulty_.p_BT[arm]);
    figures_.golden_motion[arm] = farther(figures_.golden_motion[arm], golden.p_BT[arm], start_golden_.p_BT[arm]);
  }
  measureJump(deviation);
}

void Comparison::measureJump(const Deviation& deviation) noexcept {
  for (const Deviation& past : past_) {
    for (std::size_t arm = 0; arm < kArmCount; ++arm) {
      const double change = distance(deviation[arm], past[arm]);
      figures_.max_jump = std::max(figures_.max_jump, change);
      if (change > limits_.jump && figures_.jumped == kNever) figures_.jumped = now();
    }
  }
  past_[1] = past_[0];
  past_[0] = deviation;
}

void Comparison::watchStops(const Sample& faulty) noexcept {
  if (faulty.soft_estopped != 0 && figures_.software_stop == kNever) figures_.software_stop = now();
  // A PLC that was never started is no stop.
  if (plc_left_ && faulty.plc == RunLevel::kEStop && figures_.plc_stop == kNever) figures_.plc_stop = now();
  const bool knows = faulty.software == RunLevel::kEStop && faulty.program == ProgramState::kRunning;
  if (figures_.plc_stop != kNever && knows && figures_.reported == kNever) figures_.reported = now();
}

void Comparison::watchForce(const Sample& golden, const Sample& faulty) noexcept {
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    figures_.max_force = std::max(figures_.max_force, faulty.force[arm]);
    const bool felt = faulty.force[arm] >= limits_.force && golden.force[arm] < limits_.force;
    if (felt && figures_.force == kNever) figures_.force = now();
  }
}

bool isOutcome(const std::string& text) {
  return text != name(Outcome::kNone) &&
         std::find(kOutcomeNames.begin(), kOutcomeNames.end(), text) != kOutcomeNames.end();
}

Outcome classify(Ending ending, const Figures& figures, const Limits& limits) noexcept {
  if (ending == Ending::kNoEnd) return Outcome::kNone;
  if (ending == Ending::kDied || ending == Ending::kMemory) return Outcome::kCrash;
  if (ending == Ending::kBudget) return Outcome::kHang;
  if (figures.program == ProgramState::kCrashed) return Outcome::kCrash;
  if (figures.program == ProgramState::kHung) return Outcome::kHang;
  if (figures.max_jump > limits.jump || figures.is_finite == 0) return Outcome::kUnsafeJump;
  if (figures.software_stop != kNever || figures.plc_stop != kNever) return Outcome::kEStop;
  if (didNotMove(figures, limits) || didNotStart(figures, limits)) return Outcome::kNoMotion;
  return maxDeviation(figures) > limits.masked ? Outcome::kSlowDeviation : Outcome::kMasked;
}

}  // namespace raven2_trainer::campaign
