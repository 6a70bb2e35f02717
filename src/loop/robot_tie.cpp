#include "loop/robot_tie.h"

namespace raven2_trainer::loop {
namespace {

constexpr double kNanoseconds = 1e9;

// A link silent for this long is lost: model and robot must start again from a common pose. Shorter gaps only
// silence the cue (stale_after); a busy host stalls for some tens of milliseconds now and then.
constexpr std::int64_t kLostAfter = 500'000'000;  // [ns]

constexpr std::uint64_t kDeafCycles = 1000;  // [1 ms] ours: twice the mean of net_delay_3

}  // namespace

RobotTie::RobotTie(double stale_after) noexcept : stale_ns_(static_cast<std::int64_t>(stale_after * kNanoseconds)) {}

void RobotTie::hear(const StateCell<RobotState>& newest, std::int64_t now_ns) noexcept {
  newest.tryLoad(&robot_);
  const std::int64_t age = now_ns - robot_.received_ns;
  was_heard_ = was_heard_ || isHeard();
  is_fresh_ = isHeard() && age <= stale_ns_;
  is_silent_ = age > kLostAfter;
  if (isLost()) is_linked_ = false;
}

void RobotTie::listen() noexcept {
  const bool is_new = robot_.cycle < heard_cycle_;
  const bool has_changed = robot_.last_sequence != heard_sequence_;
  reports_sequence_ = !is_new && (reports_sequence_ || (has_changed && heard_cycle_ > 0));
  if (is_new || has_changed) {
    heard_sequence_ = robot_.last_sequence;
    heard_cycle_ = robot_.cycle;
  }
  // In PEDAL_DN it may have heard neither the release before this press nor the press.
  const bool took_press = robot_.runlevel == RunLevel::kPedalDown && heardSinceLink();
  if (is_linked_ && !took_press && isDeaf()) is_unheard_ = true;
}

/** Packets go to the robot in every tick, also with the pedal up. */
bool RobotTie::isDeaf() const noexcept {
  return reports_sequence_ && robot_.cycle - heard_cycle_ > kDeafCycles;
}

void RobotTie::forgetOld() noexcept {
  const bool is_new = robot_.cycle < last_cycle_;
  last_cycle_ = robot_.cycle;
  if (!isHeard() || is_new || robot_.homed == 0) is_ready_ = false;
  if (!is_ready_ || robot_.runlevel < RunLevel::kPedalUp) is_linked_ = false;
}

bool RobotTie::becomesReady() noexcept {
  if (is_ready_ || robot_.homed == 0 || robot_.runlevel != RunLevel::kPedalUp) return false;
  is_ready_ = true;
  return true;
}

void RobotTie::link(bool is_common) noexcept {
  is_linked_ = is_common;
  linked_cycle_ = heard_cycle_;
  is_unheard_ = is_common && isDeaf();
}

bool RobotTie::applies() const noexcept {
  return !is_linked_ || (robot_.runlevel == RunLevel::kPedalDown && !is_unheard_);
}

}  // namespace raven2_trainer::loop
