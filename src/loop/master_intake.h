#pragma once

#include "loop/loop_faults.h"
#include "loop/servo_manager.h"
#include "loop/stage.h"

namespace raven2_trainer::loop {

/** Takes the commands of masters and CRTK clients, and makes one tick's increments and pedal of them, with the changes
 * that faults make. One thread; real-time safe. */
class MasterIntake {
 public:
  MasterIntake(LoopFaults* faults, ServoManager* servo, Stage* stage) noexcept;

  /** Once a tick. @param[in] may_teleoperate a pedal-down leads to teleoperation, now or once the robot is ready. */
  void tick(bool may_teleoperate) noexcept;
  /** Number of the newest command that was taken, behind the faults; 0 before the first. */
  std::uint32_t newest() const noexcept { return newest_; }

 private:
  void begin() noexcept;
  void takeConsole() noexcept;
  void takeHeld() noexcept;
  ServoSituation servoStand(bool may_teleoperate) const noexcept;
  void consume(const MasterCommand& command) noexcept;
  void take(const MasterCommand& command) noexcept;
  bool fits(const MasterCommand& command) const noexcept;

  LoopFaults& faults_;
  ServoManager& servo_;
  Stage& stage_;
  Tick silent_ticks_{0};  ///< since the last command
  Tick silence_limit_;
  std::uint32_t newest_{0};
};

}  // namespace raven2_trainer::loop
