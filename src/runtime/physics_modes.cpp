#include <algorithm>
#include <cmath>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/runtime/physics_loop.h"

// The part of the physics loop that changes its mode: pedals, run levels and requests; and what keeps model and robot
// together, or brings them together again.

namespace raven2_trainer::runtime {
namespace {

using control::Event;

// While the pedal is up the model moves to the robot's joints, no joint faster than hands move it, so that what
// the jaws hold stays held. A robot farther away than this (first seen, homing) is another matter: the model is put
// there. Shoulder to wrist.
constexpr std::array<double, kGrasp1> kFollowReach{0.15, 0.15, 0.05, 0.8, 0.8};  // [rad, m]
constexpr std::array<double, kGrasp1> kFollowSpeed{0.5, 0.5, 0.1, 3.0, 3.0};     // [rad/s, m/s]

constexpr std::uint64_t kDeafCycles = 1000;  // [1 ms] ours: twice the mean of net_delay_3

constexpr double kFollowTime = 0.010;  // [s] time constant of that motion: 5 mm are gone within a clutch of 60 ms

bool isWithinReach(const JointArray& q, const JointArray& target) noexcept {
  for (std::size_t j = 0; j < kFollowReach.size(); ++j) {
    if (std::abs(q[j] - target[j]) > kFollowReach[j]) return false;
  }
  return true;
}

/** The model moves, or holds, where the robot does not follow. */
bool isAlone(Mode mode) noexcept {
  switch (mode) {
    case Mode::kTracking:
    case Mode::kSimulating:
    case Mode::kSimulationHeld:
    case Mode::kTrial:
    case Mode::kTrialHeld:
      return true;
    default:
      return false;
  }
}

/** What releasing the camera's pedal leads back to. */
Event cameraLeft(Mode from) noexcept {
  switch (from) {
    case Mode::kSimulating:
    case Mode::kSimulationHeld:
      return Event::kCameraLeftAlone;
    case Mode::kTrial:
    case Mode::kTrialHeld:
      return Event::kCameraLeftOnTape;
    default:
      return Event::kCameraLeft;
  }
}

}  // namespace

// ---- events ------------------------------------------------------------------------------------------------------

void PhysicsLoop::updateRobotEvents() noexcept {
  if (!world_.healthy()) raise(Event::kEmergencyStop);
  forgetOldRobot();
  if (robot_there_ && !robot_ready_) loseRobot();  // a new one may be ready within this tick
  if (state_.robot_fresh != 0) updateRunLevelEvents();
  const bool is_there = robot_ready_ && !isRobotLost();
  if (robot_there_ && robot_ready_ && !is_there) loseRobot();
  robot_there_ = is_there;
}

void PhysicsLoop::updateRunLevelEvents() noexcept {
  const bool in_stop = robot_.runlevel == RunLevel::kEStop;
  if (robot_ready_ && in_stop && state_.mode != Mode::kStopped) {
    stopped_by_robot_ = true;
    raise(Event::kEmergencyStop);
  } else if (stopped_by_robot_ && robot_.runlevel >= RunLevel::kPedalUp) {
    stopped_by_robot_ = false;
    if (!stop_asked_) raise(Event::kStopCleared);
  }
  if (!robot_ready_ && robot_.homed != 0 && robot_.runlevel == RunLevel::kPedalUp) {
    robot_ready_ = true;
    raise(Event::kRobotReady);
  }
}

/** A robot that went away, started anew or is not homed is another robot: nothing known of the old one holds. */
void PhysicsLoop::forgetOldRobot() noexcept {
  const bool is_gone = robot_.connected == 0 || robot_.frame == 0;
  const bool is_new = robot_.cycle < last_cycle_;
  last_cycle_ = robot_.cycle;
  if (is_gone || is_new || robot_.homed == 0) robot_ready_ = false;
  if (!robot_ready_ || robot_.runlevel < RunLevel::kPedalUp) linked_ = false;
}

void PhysicsLoop::updatePedal() noexcept {
  const bool pressed = pedal_ && !pedal_before_;
  const bool released = !pedal_ && pedal_before_;
  // Asked again next tick: the pedal counts once the robot is homed, and the model back on it.
  if (pressed && (isRobotNotReady() || waitsForReturn())) return;
  pedal_before_ = pedal_;
  state_.pedal = heldPedal();
  if (pressed && mayPress()) raise(Event::kPedalPressed);
  if (!released) return;
  if (state_.mode == Mode::kExecuting) endExecution(ExecutionEnd::kReleased);
  raise(Event::kPedalReleased);
}

void PhysicsLoop::raise(Event event) noexcept {
  const Mode next = control::nextMode(state_.mode, event);
  if (next == state_.mode) return;
  settleTrial(next, event);
  settlePlanning(next, event);
  enter(next);
  if (next == Mode::kPedalUp && mustReturn()) raise(Event::kReturnWanted);
  endRehearsal();
}

/** @return whether the event changed anything. */
PlanningAnswer PhysicsLoop::ask(Event event) noexcept {
  const Mode before = state_.mode;
  raise(event);
  return state_.mode != before ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow;
}

void PhysicsLoop::enter(Mode next) noexcept {
  const Mode before = state_.mode;
  state_.mode = next;
  if (before == Mode::kTracking) follower_.stop();
  if (before == Mode::kReplaying) standAgain();
  const bool moves_robot = next == Mode::kTeleoperating || (next == Mode::kExecuting && movesRobot());
  linked_ = moves_robot && robotJoins();
  is_unheard_ = false;
  if (linked_) joinRobot();
  placeForPlanning(before, next);
  const bool begins_alone = (next == Mode::kTeleoperating || next == Mode::kExecuting) && !linked_;
  if (isAlone(next) || begins_alone) leaveRobot();
  rebaseArms();
  if (next == Mode::kReturning) beginReturn();
  if (next == Mode::kTrial) trial_.mark();
  if (next == Mode::kExecuting) beginExecution();
  const bool begins =
      next == Mode::kTeleoperating || next == Mode::kExecuting || next == Mode::kSimulating || next == Mode::kTrial;
  if (begins && state_.session_tick < 0) state_.session_tick = 0;
}

/** Whatever comes next starts from where the arms are. */
void PhysicsLoop::rebaseArms() noexcept {
  for (const Arm arm : kArms) {
    at(mappers_, arm).rebasePose(modelJoints(arm));
    driver_.reset(arm);
    at(q_d_, arm) = at(mappers_, arm).desired();
  }
}

bool PhysicsLoop::robotJoins() const noexcept {
  return isRobotThere() && state_.engaged != 0;
}

/** Packets go to the robot in every tick, also with the pedal up. */
bool PhysicsLoop::isRobotDeaf() const noexcept {
  return tells_sequence_ && robot_.cycle - heard_cycle_ > kDeafCycles;
}

void PhysicsLoop::listenToRobot() noexcept {
  const bool is_new = robot_.cycle < heard_cycle_;
  const bool has_changed = robot_.last_sequence != heard_sequence_;
  tells_sequence_ = !is_new && (tells_sequence_ || (has_changed && heard_cycle_ > 0));
  if (is_new || has_changed) {
    heard_sequence_ = robot_.last_sequence;
    heard_cycle_ = robot_.cycle;
  }
  if (linked_ && robot_.runlevel != RunLevel::kPedalDown && isRobotDeaf()) is_unheard_ = true;
}

/** Both sides must apply the same increments: the robot does so from the cycle in which it reports PEDAL_DN. */
bool PhysicsLoop::robotApplies() const noexcept {
  return !linked_ || (robot_.runlevel == RunLevel::kPedalDown && !is_unheard_);
}

// ---- requests ----------------------------------------------------------------------------------------------------

void PhysicsLoop::serveTraining(const Request& request) noexcept {
  desk_.answer(request.id, answerTraining(request));
}

PlanningAnswer PhysicsLoop::answerTraining(const Request& request) noexcept {
  switch (request.kind) {
    case RequestKind::kBeginSimulation:
      return mayBegin() ? ask(Event::kSimulationWanted) : PlanningAnswer::kNotNow;
    case RequestKind::kEndSimulation:
      return isPedalUp() ? ask(Event::kSimulationEnded) : PlanningAnswer::kNotNow;
    case RequestKind::kBeginTrial:
      return beginTrial();
    case RequestKind::kEndTrial:
      return ask(Event::kTrialDone);
    case RequestKind::kDiscardTrial:
      return discardTrial();
    case RequestKind::kRepeatTrial:
      return repeatTrial(request);
    case RequestKind::kEmergencyStop:
      stop();
      return PlanningAnswer::kAccepted;
    case RequestKind::kClearStop:
      return clearStop();
    case RequestKind::kSetView:
      state_.view = request.enabled != 0 ? 1 : 0;
      return PlanningAnswer::kAccepted;
    case RequestKind::kSetCameraPedal:
      return pressCamera(static_cast<CameraPedal>(request.enabled));
    case RequestKind::kToolChange:
      return changeTool();
    case RequestKind::kStartExercise:
      return restartExercise();
    case RequestKind::kBeginReplay:
      return beginReplay(request);
    case RequestKind::kEndReplay:
      return ask(Event::kReplayEnded);
    default:
      return PlanningAnswer::kNotNow;  // nothing that is served here
  }
}

/** Not while anything moves: what the jaws hold would be gone from between them. */
PlanningAnswer PhysicsLoop::restartExercise() noexcept {
  const bool rests =
      state_.mode == Mode::kWaiting || state_.mode == Mode::kPedalUp || state_.mode == Mode::kSimulationHeld;
  if (!exercise_.hasExercise() || !rests || !isPedalUp()) return PlanningAnswer::kNotNow;
  exercise_.restart();
  return PlanningAnswer::kAccepted;
}

/** The robot is told pedal-up in this tick, and until the stop is cleared: ITP has no more than that. */
void PhysicsLoop::stop() noexcept {
  stop_asked_ = true;
  raise(Event::kEmergencyStop);
}

PlanningAnswer PhysicsLoop::clearStop() noexcept {
  if (!stop_asked_ || !isPedalUp() || !world_.healthy()) return PlanningAnswer::kNotNow;
  stop_asked_ = false;
  if (!stopped_by_robot_) raise(Event::kStopCleared);
  return PlanningAnswer::kAccepted;
}

/** Counted for faults' triggers; an instrument is changed with the pedal up. */
PlanningAnswer PhysicsLoop::changeTool() noexcept {
  if (!isPedalUp()) return PlanningAnswer::kNotNow;
  ++tool_changes_;
  return PlanningAnswer::kAccepted;
}

/** A pedal that is still down when the camera's goes up is pressed anew in the same tick; not when silence took the
 *  camera from a surgeon who goes on moving it: then it takes a pedal-down of its own. */
PlanningAnswer PhysicsLoop::pressCamera(CameraPedal pedal) noexcept {
  const Mode before = state_.mode;
  const bool is_moving = before == Mode::kCameraMoving;
  if ((pedal == CameraPedal::kPressed) == is_moving) return PlanningAnswer::kNotNow;
  if (is_moving) {
    dropMotion();
    pedal_before_ = pedal == CameraPedal::kSilent && pedal_;
    return ask(cameraLeft(camera_from_));
  }
  const PlanningAnswer answer = ask(Event::kCameraPressed);
  if (answer == PlanningAnswer::kAccepted) camera_from_ = before;
  return answer;
}

void PhysicsLoop::moveCamera() noexcept {
  Vec3 mean_I{};
  for (const Vec3& dp : increments_.dp_I) {
    for (std::size_t i = 0; i < mean_I.size(); ++i)
      mean_I[i] += 0.5 * dp[i];
  }
  camera_.move(mean_I);
  useCommands();
}

// ---- model and robot ---------------------------------------------------------------------------------------------

PerArm<JointArray> PhysicsLoop::robotJoints() const noexcept {
  return {robot_.arms[0].q, robot_.arms[1].q};
}

PerArm<JointArray> PhysicsLoop::standing() const noexcept {
  return {modelJoints(Arm::kGold), modelJoints(Arm::kGreen)};
}

JointArray PhysicsLoop::followRobot(Arm arm) noexcept {
  is_apart_ = false;
  at(mappers_, arm).rebase(at(robot_.arms, arm).q);
  at(q_d_, arm) = at(mappers_, arm).desired();
  return bringTo(arm, at(q_d_, arm));
}

/** Shoulder to wrist get the rates that bring them to the joints within some milliseconds: they move there, what the
 * jaws hold moves along. @return what to ask of the controllers, so that they do not brake it. */
JointArray PhysicsLoop::bringTo(Arm arm, const JointArray& wanted) noexcept {
  if (world_.isObstructed(arm)) return wanted;  // no harder than the controllers can
  JointArray q{}, dq{};
  world_.jointState(arm, &q, &dq);
  if (!isWithinReach(q, wanted)) {
    world_.setJointState(arm, wanted, JointArray{});
    return wanted;
  }
  for (std::size_t j = 0; j < kFollowReach.size(); ++j)
    dq[j] = std::clamp((wanted[j] - q[j]) / kFollowTime, -kFollowSpeed[j], kFollowSpeed[j]);
  world_.setJointState(arm, q, dq);
  JointArray target = driver_.leading(arm, {q, dq});
  std::copy(wanted.begin() + kGrasp1, wanted.end(), target.begin() + kGrasp1);
  return target;
}

/** The common pose from which both start at pedal down. The jaws keep their opening: they may hold something. */
void PhysicsLoop::joinRobot() noexcept {
  is_apart_ = false;
  for (const Arm arm : kArms) {
    JointArray q{}, dq{};
    world_.jointState(arm, &q, &dq);
    const JointArray& robot = at(robot_.arms, arm).q;
    const double opening = kinematics::jawOpening(q);
    std::copy_n(robot.begin(), kFollowReach.size(), q.begin());
    kinematics::setJaws(kinematics::jawMidline(robot), opening, &q);
    world_.setJointState(arm, q, JointArray{});
  }
}

/** The jaws' openings that model and robot have in common are what the model comes back with. */
void PhysicsLoop::leaveRobot() noexcept {
  if (is_apart_) return;
  is_apart_ = true;
  takeOpenings();
}

void PhysicsLoop::takeOpenings() noexcept {
  for (const Arm arm : kArms)
    at(joint_opening_, arm) = at(mappers_, arm).opening();
}

/** A pedal-down has to wait until the model is back on the robot, and sets it on its way if it is not yet. */
bool PhysicsLoop::waitsForReturn() noexcept {
  if (mustReturn()) raise(Event::kReturnWanted);
  return state_.mode == Mode::kReturning;
}

/** To the robot; where there is none, to where the trial began. */
void PhysicsLoop::beginReturn() noexcept {
  const bool has_goal = isRobotThere() || trial_.isOpen();
  PerArm<JointArray> goal = isRobotThere() ? robotJoints() : trial_.isOpen() ? trial_.start() : standing();
  for (const Arm arm : kArms) {
    const double opening = has_goal ? at(joint_opening_, arm) : at(mappers_, arm).opening();
    kinematics::setJaws(kinematics::jawMidline(at(goal, arm)), opening, &at(goal, arm));
  }
  return_.start(standing(), goal);
}

/** There is a robot, and it is not where the model is, or was. [rad; m] */
bool PhysicsLoop::isAstray(const PerArm<JointArray>& from) const noexcept {
  if (!isRobotThere()) return false;
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kGrasp1; ++j) {
      const double off = std::abs(at(from, arm)[j] - at(robot_.arms, arm).q[j]);
      if (off > config_.execution.start_tolerance[j]) return true;
    }
  }
  return false;
}

void PhysicsLoop::superviseReturn() noexcept {
  if (state_.mode == Mode::kPedalUp && mustReturn()) raise(Event::kReturnWanted);
  if (state_.mode != Mode::kReturning || !return_.isOver()) return;
  if (isAstray(return_.goal())) return beginReturn();
  if (trial_.isUnderWay() && pedal_) return;  // to repeat it takes a pedal-down of its own
  if (isRobotThere()) is_apart_ = false;      // else whoever comes is gone to
  for (const Arm arm : kArms)
    at(mappers_, arm).setOpening(kinematics::jawOpening(at(return_.goal(), arm)));
  if (trial_.isUnderWay()) return armRepeat();
  raise(Event::kReturned);
}

}  // namespace raven2_trainer::runtime
