#include "raven2_trainer/runtime/physics_loop.h"

// The part of the physics loop that takes the masters' commands: those of the surgeon's console, and what CRTK clients
// ask for.

namespace raven2_trainer::runtime {

using control::Event;

/** As many as this tick may take. */
void PhysicsLoop::drainConsole() noexcept {
  MasterCommand command;
  for (const MasterCommand* next = nullptr; (next = shared_.master_commands.front()) != nullptr;) {
    if (servo_.overrules(*next)) {
      shared_.master_commands.tryPop(&command);
      shared_.master_overruled.add();
      continue;
    }
    if (!fits(*next)) return;
    shared_.master_commands.tryPop(&command);
    servo_.hear(command);
    consume(command);
  }
}

void PhysicsLoop::serveClients() noexcept {
  MasterCommand command;
  if (!servo_.next(servoStand(), mappers_, &command)) return;
  shared_.servo_made.add();
  consume(command);
}

ServoStand PhysicsLoop::servoStand() const noexcept {
  const bool returns = state_.mode == Mode::kReturning && !trial_.isUnderWay();
  ServoStand stand;
  stand.mode = state_.mode;
  stand.teleoperates = state_.mode == Mode::kTeleoperating || returns ||
                       control::nextMode(state_.mode, Event::kPedalPressed) == Mode::kTeleoperating;
  stand.robot_there = !isRobotLost();
  stand.robot_stopped = stand.robot_there && robot_.runlevel == RunLevel::kEStop;
  stand.robot_homed = robot_.homed != 0;
  stand.robot_ready = robot_ready_;
  stand.is_healthy = world_.healthy();
  stand.stop_asked = stop_asked_;
  stand.linked = isRobotLed();
  stand.is_unheard = is_unheard_;
  stand.applies = robotApplies();
  stand.keeps_back = !master_stream_.isEmpty();
  stand.pedal_down = pedal_;
  stand.is_taken = increments_.commands > 0;
  for (const Arm arm : kArms)
    at(stand.robot_q, arm) = at(robot_.arms, arm).q;
  return stand;
}

}  // namespace raven2_trainer::runtime
