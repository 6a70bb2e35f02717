#include "raven/state_machine.h"

#include <algorithm>

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::raven {
namespace {

constexpr int kConfirmCycles = 3;   // differing cycles before the one that counts; never cleared on agreement
constexpr int kAmplifierWait = 10;  // cycles of sub-level 2
constexpr int kWatchdogHalf = 25;   // cycles high, then as many low

}  // namespace

RunLevel StateMachine::levelOf(std::uint8_t gold_pins, std::uint8_t green_pins) noexcept {
  return static_cast<RunLevel>(std::min(gold_pins >> pins::kLevelShift, green_pins >> pins::kLevelShift));
}

void StateMachine::follow(RunLevel wanted) noexcept {
  if (wanted == level_) return;
  if (differing_cycles_ < kConfirmCycles) {
    ++differing_cycles_;
    return;
  }
  level_ = wanted;
  differing_cycles_ = 0;
}

void StateMachine::step(bool homed) noexcept {
  if (level_ == RunLevel::kInit) stepInit(homed);
  if (level_ != RunLevel::kEStop) return;
  initialized_ = false;
  sub_level_ = 0;
  soft_estopped_ = false;
}

void StateMachine::startInPedalUp() noexcept {
  level_ = RunLevel::kPedalUp;
  sub_level_ = 3;
  initialized_ = true;
}

void StateMachine::stepInit(bool homed) noexcept {
  switch (sub_level_) {
    case 0:
      sub_level_ = 1;
      break;
    case 1:
      sub_level_ = 2;
      wait_cycles_ = 0;
      break;
    case 2:
      if (++wait_cycles_ > kAmplifierWait) sub_level_ = 3;
      break;
    default:
      initialized_ = homed;
      break;
  }
}

std::uint8_t StateMachine::outputPins(const Outputs& outputs) noexcept {
  auto out = static_cast<unsigned>(outputs.level);
  if (outputs.pedal && outputs.level > RunLevel::kInit) out |= pins::kFootPedal;
  if (outputs.initialized) out |= pins::kReady;
  watchdog_phase_ = (watchdog_phase_ + 1) % (2 * kWatchdogHalf);
  if (watchdog_phase_ >= kWatchdogHalf && !soft_estopped_) out |= pins::kWatchdog;
  return static_cast<std::uint8_t>(out);
}

}  // namespace raven2_trainer::raven
