#include "loop/servo_manager.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/control/operating_state.h"
#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::loop {
namespace {

using control::ServoVerdict;

// [1 a tick] Commands that are checked: poses of a move are checked one by one along its path.
constexpr int kMostCommands = 32;
constexpr int kMostMoves = 1;
constexpr double kNoTurn = 1e-9;     // [rad] rounding
constexpr double kSamePoint = 1e-9;  // [m]
constexpr Tick kRestTicks = 200;  // a set point that does not change: the robot's arm has stopped, too

/** The largest increment that an ITP receiver accepts limits the speed of all clients. */
CrtkConfig withinRules(CrtkConfig crtk, const ItpRules& rules) {
  crtk.max_speed = std::min(crtk.max_speed, rules.max_increment_um * 1e-6 / kTickSeconds);
  crtk.max_turn_rate = std::min(crtk.max_turn_rate, rules.max_rotation / kTickSeconds);
  crtk.move_speed = std::min(crtk.move_speed, crtk.max_speed);
  crtk.move_turn_rate = std::min(crtk.move_turn_rate, crtk.max_turn_rate);
  return crtk;
}

bool isMove(ServoKind kind) noexcept {
  return kind == ServoKind::kMoveJoints || kind == ServoKind::kMoveJointsBy || kind == ServoKind::kMovePose;
}

bool isForce(ServoKind kind) noexcept {
  return kind == ServoKind::kServoForces || kind == ServoKind::kServoWrench || kind == ServoKind::kServoJawForce;
}

/** Asks nothing of an arm: it needs no pedal. */
bool isSetting(ServoKind kind) noexcept {
  return kind == ServoKind::kRatio || kind == ServoKind::kGravity || kind == ServoKind::kTool ||
         kind == ServoKind::kEndTwist || kind == ServoKind::kEndRates || kind == ServoKind::kEndForces;
}

bool isOfJaw(ServoKind kind) noexcept {
  return kind == ServoKind::kServoJaw || kind == ServoKind::kServoJawBy || kind == ServoKind::kMoveJaw ||
         kind == ServoKind::kMoveJawBy;
}

/** The robot that is there, once it has left INIT, too: before that, requests are refused. Else the model. */
bool isHomed(const ServoSituation& stand) noexcept {
  return !stand.robot_there || (stand.robot_homed && stand.robot_ready);
}

bool isReady(const ServoSituation& stand) noexcept {
  return stand.robot_there && stand.robot_ready;
}

/** A move along whose way joints were looked for. */
bool isCostly(ServoKind kind, ServoRefusal reason) noexcept {
  return isMove(kind) && (reason == ServoRefusal::kNone || reason == ServoRefusal::kUnreachable);
}

bool letsGo(const ServoCommand& command) noexcept {
  const bool is_state = command.kind == ServoKind::kState;
  return command.kind == ServoKind::kFree ||
         (is_state && (command.state == StateCommand::kPause || command.state == StateCommand::kDisable));
}

/** [um] In B, whole. */
Vector3 wholeStep(const Vector3& from, const Vector3& to, double most_um) noexcept {
  const Vector3 missing = ((to - from) * 1e6).unaryExpr([](double um) { return std::round(um); });
  return missing.cwiseMin(most_um).cwiseMax(-most_um);
}

Quaternion turnStep(const Matrix3& from, const Matrix3& to, double most) noexcept {
  Quaternion turn = Quaternion(to * from.transpose()).normalized();
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double angle = 2.0 * std::atan2(turn.vec().norm(), turn.w());
  if (angle < kNoTurn) return Quaternion::Identity();
  return angle <= most ? turn : Quaternion::Identity().slerp(most / angle, turn);
}

}  // namespace

ServoManager::ServoManager(const LoopConfig& config, SharedState* shared)
    : geometry_(config.arms.geometry),
      rules_(config.itp),
      shared_(*shared),
      targets_{control::ServoTarget(withinRules(config.crtk, rules_), geometry_, Arm::kGold),
               control::ServoTarget(withinRules(config.crtk, rules_), geometry_, Arm::kGreen)},
      rests_{Rest{control::ServoTrim(config.crtk.trim_time, geometry_)},
             Rest{control::ServoTrim(config.crtk.trim_time, geometry_)}},
      gains_(config.model.gains),
      console_limit_(toTicks(rules_.pedalTimeout())),
      idle_limit_(toTicks(config.crtk.release_after)),
      push_ticks_(toTicks(twistTimeout(config.crtk))),
      is_raven_(config.crtk.dialect == CrtkDialect::kRaven) {}

// ---- who has the pedal -------------------------------------------------------------------------------------------

void ServoManager::hear(const MasterCommand& command) noexcept {
  console_silence_ = 0;
  const bool was_down = console_pedal_;
  console_pedal_ = command.pedal != 0;
  if (console_pedal_ == was_down) return;
  holds_pedal_ = releases_ = has_released_ = false;  // taken: it stays down
  forget();
  state_ = console_pedal_ ? OperatingState::kEnabled : OperatingState::kPaused;
}

/** Its pedal-down was seen: a fault may lose a single pedal-up. */
void ServoManager::settleRelease(const ServoSituation& stand) noexcept {
  if (has_released_ && !stand.pedal_down) releases_ = false;
  has_released_ = false;
}

/** Events of the arms since the last tick, and their meaning for the clients. */
void ServoManager::observe(const ServoSituation& stand) noexcept {
  if (console_pedal_ && ++console_silence_ >= console_limit_) {
    console_pedal_ = false;
    state_ = OperatingState::kPaused;
  }
  if (holds_pedal_ && hasLostPedal(stand)) letGo(OperatingState::kPaused);
  if (holds_pedal_ && stand.mode == Mode::kCameraMoving) forget();
  const bool was_homing = isHoming();
  stand_ = stand;
  is_unhomed_ = is_unhomed_ && (was_homing || !isHoming());  // until the robot homes again
  if (stand.mode != Mode::kCameraMoving) is_joined_ = stand.linked;
  had_robot_ = had_robot_ || stand.robot_there;
  was_started_ = stand.robot_there && (was_started_ || !stand.robot_stopped);
  if (isInFault()) {
    if (state_ != OperatingState::kFault) letGo(OperatingState::kFault);
  } else if (state_ == OperatingState::kFault || stand.mode == Mode::kStopped) {
    if (state_ != OperatingState::kDisabled) letGo(OperatingState::kDisabled);
    disable_asked_ = false;
  } else {
    settleRavensState(stand);
  }
}

/** Of a Raven that is homed and has its pedal up, the robot's own branch says PAUSED, from the start on. */
void ServoManager::settleRavensState(const ServoSituation& stand) noexcept {
  const bool is_homed = isHomed(stand) && !is_unhomed_;
  if (!is_raven_ || disable_asked_ || stand.stop_asked) return;
  if (state_ == OperatingState::kDisabled && is_homed) state_ = OperatingState::kPaused;
  if (state_ == OperatingState::kPaused && !is_homed) state_ = OperatingState::kDisabled;
}

/** Whether the motion that began with the client's pedal-down is over. Time was lost, the robot went away or no longer
 * follows, or a robot came while the model moved alone. Or the motion never began, since a request of the same tick
 * came first. The camera's pedal lets go of the robot, which is joined again afterwards. */
bool ServoManager::hasLostPedal(const ServoSituation& stand) const noexcept {
  if (!traitsOf(stand.mode).clients_hold && !stand.teleoperates) return true;
  if (!presses_ || !traitsOf(stand_.mode).clients_hold) return false;
  const bool has_parted = is_joined_ && !stand.linked && stand.mode != Mode::kCameraMoving;
  const bool is_refused = stand_.applies && !stand.applies && stand_.mode != Mode::kCameraMoving;
  const bool has_come = !is_joined_ && !stand.linked && isReady(stand) && !isReady(stand_);
  return !traitsOf(stand.mode).clients_hold || has_parted || is_refused || has_come || stand.is_unheard;
}

void ServoManager::letGo(OperatingState state) noexcept {
  releases_ = releases_ || holds_pedal_;
  holds_pedal_ = false;
  state_ = state;
  forget();
}

void ServoManager::forget() noexcept {
  for (const Arm arm : kArms) {
    at(targets_, arm).hold();
    endPush(arm);
  }
}

/** A message that no command could be made of is a sign of life, too. */
void ServoManager::releaseIdle() noexcept {
  const std::uint64_t unread = shared_.servo_unread.value();
  const bool is_silent = holds_pedal_ && !isMoving() && unread == unread_;
  unread_ = unread;
  idle_ = is_silent ? idle_ + 1 : 0;
  if (idle_limit_ > 0 && idle_ >= idle_limit_) letGo(OperatingState::kPaused);
}

// ---- commands ----------------------------------------------------------------------------------------------------

void ServoManager::drain() noexcept {
  ServoQueue& queue = shared_.servo_commands;
  const std::uint64_t asked = queue.asked();  // first: no motion overtakes an order that it was given behind
  ServoOrder order;
  for (std::size_t i = 0; i < ServoQueue::kOrders && queue.popOrder(&order); ++i)
    serveOrder(order);
  ServoCommand command;
  for (int commands = 0, moves = 0; commands < kMostCommands && moves < kMostMoves && queue.taken() < asked;) {
    const std::uint64_t number = queue.taken();
    if (!queue.popMotion(&command)) return;
    if (number < at(over_, command.arm)) {
      ++received_;
      continue;
    }
    const ServoVerdict verdict = number < enabled_ ? ServoVerdict{ServoRefusal::kNotEnabled} : judge(command);
    serve(command, verdict);
    if (isCostly(command.kind, verdict.reason)) ++moves;
    ++commands;
  }
}

/** A hold or a pause also ends motions that came after it and still wait. An order to enable ends none. */
void ServoManager::serveOrder(const ServoOrder& order) noexcept {
  const bool was_enabled = state_ == OperatingState::kEnabled, held = holds_pedal_;
  const ServoVerdict verdict = judge(order.command);
  serve(order.command, verdict);
  if (verdict.reason != ServoRefusal::kNone) return;
  if (order.command.kind == ServoKind::kHold) at(over_, order.command.arm) = order.behind;
  if (letsGo(order.command) && was_enabled) over_ = {order.behind, order.behind};
  if (holds_pedal_ && !held) enabled_ = order.behind;
}

void ServoManager::serve(const ServoCommand& command, const ServoVerdict& verdict) noexcept {
  idle_ = 0;
  ++received_;
  if (verdict.reason == ServoRefusal::kNone) return;
  ++refused_;
  ServoRefused refused;
  refused.id = command.id;
  refused.kind = command.kind;
  refused.state = command.kind == ServoKind::kFree ? StateCommand::kPause : command.state;  // what it amounts to
  refused.reason = verdict.reason;
  refused.in = state_;  // a refusal changes none
  refused.arm = command.arm;
  refused.joint = verdict.joint;
  refused.is_turn = verdict.is_turn;
  refused.value = verdict.value;
  refused.limit = verdict.limit;
  shared_.servo_refused.tryPush(refused);
}

ServoVerdict ServoManager::judge(const ServoCommand& command) noexcept {
  if (command.kind == ServoKind::kState) return {takeState(command.state)};
  if (command.kind == ServoKind::kFree) return {takeState(StateCommand::kPause)};  // a Raven's brakes hold it
  if (command.kind == ServoKind::kTool) return {ServoRefusal::kNotOffered};
  if (command.kind == ServoKind::kGravity) return setWeight(command);
  if (command.kind == ServoKind::kEndForces) endPush(command.arm);
  if (isSetting(command.kind)) return at(targets_, command.arm).take(command);
  if (isForce(command.kind) && stand_.robot_there) return {ServoRefusal::kHasRobot};
  const ServoRefusal reason = command.kind == ServoKind::kHold ? mayHold() : mayMove();
  if (reason != ServoRefusal::kNone) return {reason};
  return isForce(command.kind) ? takeForce(command) : takeMotion(command);
}

/** The newest counts: it ends a force on what it moves. */
ServoVerdict ServoManager::takeMotion(const ServoCommand& command) noexcept {
  Push& push = at(pushes_, command.arm);
  const ServoVerdict verdict = at(targets_, command.arm).take(command);
  if (verdict.reason != ServoRefusal::kNone) return verdict;
  if (command.kind == ServoKind::kHold) {
    endPush(command.arm);
  } else if (isOfJaw(command.kind)) {
    push.has_changed = push.has_changed || push.wanted.has_jaw;
    push.wanted.has_jaw = false;
  } else {
    push.has_changed = push.has_changed || push.wanted.kind != EffortKind::kNone;
    push.wanted.kind = EffortKind::kNone;
  }
  return verdict;
}

/** The robot's own branch forgets that it is homed, and disables; here `home` remembers, for nothing has moved it. */
ServoRefusal ServoManager::takeHomed(StateCommand command) noexcept {
  if (command == StateCommand::kUnhome && !is_raven_) return ServoRefusal::kNotOffered;
  if (stand_.robot_stopped) return ServoRefusal::kRobotStop;
  if (command == StateCommand::kUnhome && console_pedal_) return ServoRefusal::kConsole;
  is_unhomed_ = command == StateCommand::kUnhome;
  if (is_unhomed_) letGo(OperatingState::kDisabled);
  return ServoRefusal::kNone;
}

ServoRefusal ServoManager::takeState(StateCommand command) noexcept {
  if (command == StateCommand::kUnhome || command == StateCommand::kHome) return takeHomed(command);
  if (is_unhomed_ && (command == StateCommand::kEnable || command == StateCommand::kResume))
    return ServoRefusal::kNotHomed;
  if (is_raven_ && command == StateCommand::kEnable && state_ == OperatingState::kPaused)
    command = StateCommand::kResume;
  if (is_raven_ && command == StateCommand::kPause && isHoming()) command = StateCommand::kDisable;
  const auto next = control::nextState(state_, command);
  if (!next) return ServoRefusal::kInvalid;
  if (stand_.robot_stopped && *next != state_) return ServoRefusal::kRobotStop;
  if (isInFault()) return stand_.robot_stopped ? ServoRefusal::kRobotStop : ServoRefusal::kMode;
  if (console_pedal_) return *next == state_ ? ServoRefusal::kNone : ServoRefusal::kConsole;
  disable_asked_ = *next == OperatingState::kDisabled;
  if (*next != OperatingState::kEnabled) {
    letGo(*next);
    return ServoRefusal::kNone;
  }
  return holds_pedal_ ? ServoRefusal::kNone : takePedal();
}

/** After an operator's stop no client starts the arms again. */
ServoRefusal ServoManager::takePedal() noexcept {
  if (stand_.stop_asked) return ServoRefusal::kOperatorStop;
  if (stand_.mode == Mode::kStopped) return ServoRefusal::kRobotStop;  // it is being started
  if (!stand_.teleoperates) return ServoRefusal::kMode;
  holds_pedal_ = true;
  state_ = OperatingState::kEnabled;
  return ServoRefusal::kNone;
}

ServoRefusal ServoManager::mayHold() const noexcept {
  if (console_pedal_) return ServoRefusal::kConsole;
  if (shownState() != state_) return ServoRefusal::kNotHomed;
  return holds_pedal_ ? ServoRefusal::kNone : ServoRefusal::kNotEnabled;
}

/** A motion that is requested before the robot takes increments waits for it. */
ServoRefusal ServoManager::mayMove() const noexcept {
  const ServoRefusal reason = mayHold();
  if (reason != ServoRefusal::kNone) return reason;
  if (stand_.robot_there && !stand_.robot_ready) return ServoRefusal::kNotHomed;
  const bool may_move = stand_.teleoperates && stand_.mode != Mode::kReturning;  // which leads elsewhere
  return may_move ? ServoRefusal::kNone : ServoRefusal::kMode;
}

// ---- a tick ------------------------------------------------------------------------------------------------------

bool ServoManager::next(const ServoSituation& stand,
                        const PerArm<control::TeleopMapper>& mappers,
                        MasterCommand* command) noexcept {
  settleRelease(stand);
  observe(stand);
  releaseIdle();
  drain();
  stepPushes();
  *command = MasterCommand{};
  command->sequence = sequence_ + 1;
  has_released_ = releases_;
  presses_ = holds_pedal_ && !releases_ && !stand.is_taken;  // pressed again: between, it is up for a tick
  command->pedal = presses_ ? kClientsPedal : 0;
  for (const Arm arm : kArms)
    aim(arm, at(mappers, arm), command);
  if (!presses_ && !releases_) return false;
  ++sequence_;
  return true;
}

/** Increments that the mapping refused led nowhere: from where the arm is asked to be, they are taken back. */
Pose ServoManager::takenBy(const control::TeleopMapper& mapper, Arm arm) const noexcept {
  if (kinematics::isUsable(mapper.status())) return mapper.desiredPose();
  return kinematics::forward(geometry_, arm, mapper.desired());
}

/** From where the commands before led to the arm's set point; nothing until they are taken. */
void ServoManager::aim(Arm arm, const control::TeleopMapper& mapper, MasterCommand* command) noexcept {
  control::ServoTarget& target = at(targets_, arm);
  Sent& sent = at(sent_, arm);
  const bool moves = command->pedal != 0 && stand_.mode == Mode::kTeleoperating && stand_.applies;
  const bool is_known = !moves || !stand_.keeps_back;
  if (is_known) {
    sent.X_BT = mapper.desiredPose();
    sent.opening = mapper.opening();
  }
  const Pose taken = is_known ? takenBy(mapper, arm) : sent.X_BT;
  const bool is_pushed = at(pushes_, arm).wanted.kind != EffortKind::kNone;
  if (!moves || is_pushed) {
    at(rests_, arm).leave();
    sent.is_at_limit = false;
    if (!moves) return target.startFrom(taken, mapper.desired(), sent.opening);
    target.startFrom(taken, mapper.desired());
  }
  const JointArray q = at(rests_, arm).trim.without(mapper.desired());
  target.keepTo(at(rests_, arm).trimmed.before(taken), q, sent.opening);
  target.step();
  const Pose asked = is_pushed ? sent.X_BT : trimmed(arm, q);
  const Pose& to = isAtLimit(asked, mapper.status(), &sent) ? sent.X_BT : asked;
  const Vector3 step_um = wholeStep(sent.X_BT.p, to.p, rules_.max_increment_um);
  const Quaternion turn = turnStep(sent.X_BT.R, to.R, rules_.max_rotation);
  const double jaw_mrad = std::round((target.opening() - sent.opening) * 1e3);
  const Matrix3& C = control::itpToBase(arm);
  Quaternion dq_I = turn;
  dq_I.vec() = C.transpose() * turn.vec();  // the axis turns, the angle stays
  at(command->dp_I, arm) = toArray(Vector3(C.transpose() * step_um * 1e-6));
  at(command->dq_I, arm) = toArray(dq_I);
  at(command->dgrasp, arm) = -jaw_mrad * 1e-3;
  sent.X_BT.p += step_um * 1e-6;
  sent.X_BT.R = (turn * Quaternion(sent.X_BT.R)).normalized().toRotationMatrix();
  sent.opening += jaw_mrad * 1e-3;
}

/** A pose that the mapping cut off at a joint's limit is asked for once: each further time moves an arm along the
 * limit. */
bool ServoManager::isAtLimit(const Pose& asked, kinematics::IkStatus status, Sent* sent) noexcept {
  const bool is_same = (asked.p - sent->asked.p).norm() < kSamePoint && (asked.R - sent->asked.R).norm() < kNoTurn;
  sent->is_at_limit = is_same && (sent->is_at_limit || status == kinematics::IkStatus::kClamped);
  if (!is_same) sent->asked = asked;
  return sent->is_at_limit;
}

/** The set point, and what friction keeps the robot from it. @param[in] q [rad; m] the set point's joints. */
Pose ServoManager::trimmed(Arm arm, const JointArray& q) noexcept {
  Rest& rest = at(rests_, arm);
  const Pose& X_BT = at(targets_, arm).pose();
  const bool is_unchanged = X_BT.p == rest.X_BT.p && X_BT.R == rest.X_BT.R;
  rest.ticks = is_unchanged ? rest.ticks + 1 : 0;
  rest.X_BT = X_BT;
  rest.trim.step(q, at(stand_.robot_q, arm), stand_.linked && rest.ticks >= kRestTicks);
  rest.trimmed = control::displacement(geometry_, arm, q, rest.trim.with(q));
  return rest.trimmed.of(X_BT);
}

bool ServoManager::isHoming() const noexcept {
  return !isHomed(stand_) && !stand_.robot_stopped;
}

/** While a Raven homes, the robot's own branch says ENABLED and busy, until a client disables it. */
OperatingState ServoManager::shownState() const noexcept {
  const bool is_off = stand_.stop_asked || disable_asked_ || is_unhomed_ || state_ != OperatingState::kDisabled;
  return is_raven_ && isHoming() && !is_off ? OperatingState::kEnabled : state_;
}

void ServoManager::publish(Tick tick, std::int64_t time_ns, const PerArm<JointArray>& q_d) noexcept {
  ServoState state;
  state.tick = tick;
  state.time_ns = time_ns;
  state.state = shownState();
  state.is_homed = isHomed(stand_) && !is_unhomed_ ? 1 : 0;
  state.holds_pedal = holds_pedal_ ? 1 : 0;
  state.alone = holds_pedal_ && stand_.mode == Mode::kTeleoperating && !stand_.linked && had_robot_ ? 1 : 0;
  for (const Arm arm : kArms) {
    ServoArmState& out = at(state.arms, arm);
    const control::ServoTarget& target = at(targets_, arm);
    const JointArray q = at(rests_, arm).trim.without(at(q_d, arm));
    out.is_busy = isHoming() || target.isMoving() ? 1 : 0;
    out.moves = target.moves();
    out.setpoint_B = toArray(kinematics::forward(geometry_, arm, q));
    out.setpoint_q = control::servoJoints(q);
    out.setpoint_jaw = kinematics::jawOpening(q);
    out.ratio = target.ratio();
    out.run_out = target.runOut() + at(forces_run_out_, arm);
    out.ended = target.ended();
    out.goal_B = target.hasGoal() ? toArray(target.goal()) : out.setpoint_B;
  }
  state.received = received_;
  state.refused = refused_;
  state.applied = received_ - refused_;
  shared_.servo.store(state);
}

}  // namespace raven2_trainer::loop
