#pragma once

#include <cstdint>

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::plant {

/**
 * The safety PLC between the boards. Its program is not public; this is the emulation of raven2.md 4.3: start button
 * 0 to 1, READY 1 to 2, foot pedal 2 to 3 and back, loss of a watchdog to 0 from anywhere. Real-time safe.
 */
class Plc {
 public:
  /** One cycle with the output bytes of both boards. */
  void step(const PerArm<std::uint8_t>& pins) noexcept;

  /** Pressed until it has taken effect. */
  void pressStart() noexcept { start_pressed_ = true; }

  /** Starts in a level with the watchdogs taken as just seen. */
  void startIn(RunLevel level) noexcept;

  RunLevel level() const noexcept { return level_; }
  std::uint8_t inputPins() const noexcept;
  /** Brakes of the positioning joints; released in INIT for homing and in PEDAL_DN. */
  bool brakesOn() const noexcept { return level_ == RunLevel::kEStop || level_ == RunLevel::kPedalUp; }
  /** Amplifiers ignore their commands in E-STOP: the software starts with full-scale garbage (raven2.md 4.6). */
  bool powered() const noexcept { return level_ != RunLevel::kEStop; }

 private:
  bool watchdogAlive(const PerArm<std::uint8_t>& pins) noexcept;
  RunLevel next(std::uint8_t common_pins) noexcept;

  static constexpr int kWatchdogLimit = 200;  // [cycles] without an edge, as in the observed emulation

  RunLevel level_{RunLevel::kEStop};
  bool start_pressed_{false};
  PerArm<std::uint8_t> last_pins_{};
  PerArm<int> edge_age_{{kWatchdogLimit, kWatchdogLimit}};
};

}  // namespace raven2_trainer::plant
