#include "plant/plc.h"

#include <algorithm>

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::plant {

namespace pins = raven::pins;

bool Plc::watchdogAlive(const PerArm<std::uint8_t>& board_pins) noexcept {
  for (const Arm arm : kArms) {
    const bool edge = ((at(board_pins, arm) ^ at(last_pins_, arm)) & pins::kWatchdog) != 0;
    at(edge_age_, arm) = edge ? 0 : std::min(at(edge_age_, arm) + 1, kWatchdogLimit);
  }
  last_pins_ = board_pins;
  return std::max(edge_age_[0], edge_age_[1]) < kWatchdogLimit;
}

RunLevel Plc::next(std::uint8_t common_pins) noexcept {
  const bool pedal = (common_pins & pins::kFootPedal) != 0;
  switch (level_) {
    case RunLevel::kEStop:
      return start_pressed_ ? RunLevel::kInit : level_;
    case RunLevel::kInit:
      return (common_pins & pins::kReady) != 0 ? RunLevel::kPedalUp : level_;
    case RunLevel::kPedalUp:
      return pedal ? RunLevel::kPedalDown : level_;
    case RunLevel::kPedalDown:
      return pedal ? level_ : RunLevel::kPedalUp;
  }
  return RunLevel::kEStop;
}

void Plc::step(const PerArm<std::uint8_t>& board_pins) noexcept {
  if (!watchdogAlive(board_pins)) {
    level_ = RunLevel::kEStop;
    return;
  }
  // A signal counts when both boards carry it.
  level_ = next(static_cast<std::uint8_t>(board_pins[0] & board_pins[1]));
  if (level_ != RunLevel::kEStop) start_pressed_ = false;
}

void Plc::startIn(RunLevel level) noexcept {
  level_ = level;
  start_pressed_ = false;
  edge_age_ = {};
}

std::uint8_t Plc::inputPins() const noexcept {
  return static_cast<std::uint8_t>(static_cast<unsigned>(level_) << pins::kLevelShift);
}

}  // namespace raven2_trainer::plant
