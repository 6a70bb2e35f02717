#pragma once

#include <cstdint>

#include "raven2_trainer/core/state.h"

namespace raven2_trainer::raven {

/** Run level and sub-level of the control software (raven2.md 4.3). Real-time safe. */
class StateMachine {
 public:
  /** The lowest of the levels on the boards' pins. */
  static RunLevel levelOf(std::uint8_t gold_pins, std::uint8_t green_pins) noexcept;

  /** Takes the level that the PLC asks for; a change counts on the 4th differing cycle. */
  void follow(RunLevel wanted) noexcept;

  /** Walks the sub-levels of INIT; `homed` lets sub-level 3 end. Clears everything in E-STOP. */
  void step(bool homed) noexcept;

  /** Overdrive check or console: all DACs zero and no watchdog until E-STOP has been reached. */
  void softEstop() noexcept { soft_estopped_ = true; }

  /** Outputs to the PLC. */
  struct Outputs {
    bool pedal{};
    RunLevel level{RunLevel::kEStop};
    bool initialized{};
  };
  /** Pins for the PLC: level echo, FP, READY, and the watchdog, which is the machine's own. */
  std::uint8_t outputPins(const Outputs& outputs) noexcept;

  RunLevel runLevel() const noexcept { return level_; }
  std::uint8_t subLevel() const noexcept { return sub_level_; }
  bool initialized() const noexcept { return initialized_; }
  /** PEDAL_UP, initialised: where homing and the PLC would have led. */
  void startInPedalUp() noexcept;
  bool softEstopped() const noexcept { return soft_estopped_; }
  /** INIT with sub-level 3, not yet READY: the time of homing. */
  bool mayHome() const noexcept { return level_ == RunLevel::kInit && sub_level_ == 3 && !initialized_; }

 private:
  void stepInit(bool homed) noexcept;

  RunLevel level_{RunLevel::kEStop};
  std::uint8_t sub_level_{0};
  bool initialized_{false};
  bool soft_estopped_{false};
  int differing_cycles_{0};
  int wait_cycles_{0};
  int watchdog_phase_{0};
};

}  // namespace raven2_trainer::raven
