#include "raven2_trainer/core/effort.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
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

/** What a client's forces may do: move a model that goes on alone. Anything else that begins ends them. */
void PhysicsLoop::pushModel(const Request& request) noexcept {
  const Effort effort = effortOf(request);
  const bool was_pushed = driver_.isPushed(request.arm);
  if (effort.isAny() && (state_.mode != Mode::kTeleoperating || linked_)) return;
  if (was_pushed && effort.kind == EffortKind::kNone) driver_.reset(request.arm);
  driver_.push(request.arm, effort);
}

/** [rad; m] The model may go ways of its own: along a plan that it tracks, in a trial, in a replay. With the pedal up a
 *  robot is asked to stand where it is. */
const PerArm<JointArray>& PhysicsLoop::robotSetPoints() noexcept {
  const Mode mode = state_.mode;
  const bool follows = mode == Mode::kPedalUp || mode == Mode::kWaiting || mode == Mode::kTeleoperating;
  const bool is_models = linked_ || !relay_started_ || follows;
  if (is_models) robot_q_d_ = q_d_;
  if (is_models || state_.robot_fresh == 0) return robot_q_d_;
  for (const Arm arm : kArms) {
    JointArray& q_d = at(robot_q_d_, arm);
    const double opening = kinematics::jawOpening(q_d);
    q_d = at(robot_.arms, arm).q;
    kinematics::setJaws(kinematics::jawMidline(q_d), opening, &q_d);
  }
  return robot_q_d_;
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
