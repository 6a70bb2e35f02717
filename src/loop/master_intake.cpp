#include "loop/master_intake.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/faults/packet_faults.h"

namespace raven2_trainer::loop {
namespace {

Vec3 sum(const Vec3& a, const Vec3& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

Quat product(const Quat& later, const Quat& earlier) noexcept {
  if (later == kIdentityQuat) return earlier;  // exact, and the common case
  return toArray((toEigen(later) * toEigen(earlier)).normalized());
}

/** A fault can change a rotation so that it is no rotation any more: then no rotation is used. */
Quat unitOrNone(const Quat& q) noexcept {
  const double norm = toEigen(q).norm();
  return norm > 1e-6 && std::isfinite(norm) ? toArray(toEigen(q).normalized()) : kIdentityQuat;
}

}  // namespace

MasterIntake::MasterIntake(LoopFaults* faults, ServoManager* servo, Stage* stage) noexcept
    : faults_(*faults), servo_(*servo), stage_(*stage), silence_limit_(toTicks(stage->config.itp.pedalTimeout())) {}

void MasterIntake::tick(bool may_teleoperate) noexcept {
  begin();
  takeConsole();
  MasterCommand command;
  if (servo_.next(servoStand(may_teleoperate), stage_.arms.mappers(), &command)) {
    stage_.shared.servo_made.add();
    consume(command);
  }
  takeHeld();
}

/** Nothing came yet, and a master that was silent for long holds no pedal. */
void MasterIntake::begin() noexcept {
  stage_.increments = Increments{};
  if (++silent_ticks_ >= silence_limit_) stage_.pedal.is_down = false;
  const int runlevel = static_cast<int>(stage_.robot.state().runlevel);
  faults_.master.beginCycle({stage_.pedal.is_down, runlevel, stage_.state.faults.signals});
}

/** As many as this tick may take. */
void MasterIntake::takeConsole() noexcept {
  auto& commands = stage_.shared.master_commands;
  MasterCommand command;
  for (const MasterCommand* next = nullptr; (next = commands.front()) != nullptr;) {
    if (servo_.overrules(*next)) {
      commands.tryPop(&command);
      stage_.shared.master_overruled.add();
      continue;
    }
    if (!fits(*next)) return;
    commands.tryPop(&command);
    servo_.hear(command);
    consume(command);
  }
}

ServoSituation MasterIntake::servoStand(bool may_teleoperate) const noexcept {
  const RobotTie& robot = stage_.robot;
  ServoSituation stand;
  stand.mode = stage_.mode();
  stand.teleoperates = may_teleoperate;
  stand.robot_there = !robot.isLost();
  stand.robot_stopped = stand.robot_there && robot.isStopped();
  stand.robot_homed = robot.state().homed != 0;
  stand.robot_ready = robot.isReady();
  stand.is_healthy = stage_.arms.world().healthy();
  stand.stop_asked = stage_.stop_asked;
  stand.linked = robot.isLed();
  stand.is_unheard = robot.isUnheard();
  stand.applies = robot.applies();
  stand.keeps_back = !faults_.master_stream.isEmpty();
  stand.pedal_down = stage_.pedal.is_down;
  stand.is_taken = stage_.increments.commands > 0;
  stand.robot_q = robot.joints();
  return stand;
}

void MasterIntake::consume(const MasterCommand& command) noexcept {
  stage_.shared.command_records.tryPush({stage_.thisTick(), command});
  for (const Arm arm : kArms) {  // where the hands really are
    Vec3& hand_I = at(stage_.state.master_I, arm);
    if (command.pedal != kClientsPedal) hand_I = sum(hand_I, at(command.dp_I, arm));
  }
  faults_.master.beginPacket(command.pedal != 0);
  if (!faults_.master.isArmed() && faults_.master_stream.isEmpty()) {
    faults_.master_stream.pass(command);
    newest_ = command.sequence;
    return take(command);
  }
  faults_.master_stream.offer(command, &faults_.master);
  takeHeld();
}

/** Those that a fault kept back, and whose time has come. */
void MasterIntake::takeHeld() noexcept {
  MasterCommand command;
  while (faults_.master_stream.take(&command, faults_.master)) {
    newest_ = command.sequence;  // a fault may change it
    faults::applyToCommand(&faults_.master, &command);
    for (Quat& dq : command.dq_I)
      dq = unitOrNone(dq);
    take(command);
  }
}

void MasterIntake::take(const MasterCommand& command) noexcept {
  stage_.pedal.is_down = command.pedal != 0;
  stage_.pedal.is_clients = command.pedal == kClientsPedal;
  silent_ticks_ = 0;
  Increments& total = stage_.increments;
  ++total.commands;
  if (!stage_.pedal.is_down && stage_.mode() != Mode::kCameraMoving) return;  // the camera has its own pedal
  for (const Arm arm : kArms) {
    at(total.dp_I, arm) = sum(at(total.dp_I, arm), at(command.dp_I, arm));
    at(total.dq_I, arm) = product(at(command.dq_I, arm), at(total.dq_I, arm));
    at(total.dgrasp, arm) += at(command.dgrasp, arm);
  }
}

/** Whether this tick may take one more. After a stall many wait: together they would be a jump, to the model as to the
 *  robot, which refuses in one packet what one packet may not hold. The ticks that catch up take the rest. */
bool MasterIntake::fits(const MasterCommand& command) const noexcept {
  const Increments& total = stage_.increments;
  if (total.commands == 0 || command.pedal == 0) return true;
  if (!stage_.pedal.is_down) return false;  // a press after a release: in one tick nobody would see that it was up
  const ItpRules& rules = stage_.config.itp;
  for (const Arm arm : kArms) {
    for (const double dp : sum(at(total.dp_I, arm), at(command.dp_I, arm))) {
      if (std::abs(dp) > rules.max_increment_um * 1e-6) return false;
    }
    const Quat turned = product(at(command.dq_I, arm), at(total.dq_I, arm));
    if (2.0 * std::acos(std::min(1.0, std::abs(toEigen(turned).w()))) > rules.max_rotation) return false;
  }
  return true;
}

}  // namespace raven2_trainer::loop
