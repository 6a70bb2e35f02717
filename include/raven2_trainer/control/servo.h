#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// Commands of a CRTK client (Collaborative Robotics Toolkit) to the arms, and their states for it. The arms move
// as by a master: commands become increments and a pedal. So model, robot, faults and the log treat them as
// a master's.

namespace raven2_trainer {

/** CRTK's operating states. */
enum class OperatingState : std::uint8_t { kDisabled, kEnabled, kPaused, kFault };
constexpr std::size_t kOperatingStateCount = 4;
constexpr std::array<const char*, kOperatingStateCount> kOperatingStateNames{"DISABLED", "ENABLED", "PAUSED", "FAULT"};

/** CRTK's state commands. */
enum class StateCommand : std::uint8_t { kEnable, kDisable, kPause, kResume, kHome, kUnhome };
constexpr std::size_t kStateCommandCount = 6;
constexpr std::array<const char*, kStateCommandCount> kStateCommandNames{"enable", "disable", "pause",
                                                                         "resume", "home",    "unhome"};

enum class ServoKind : std::uint8_t {
  kState,          ///< ServoCommand::state
  kHold,           ///< stays where it is asked to be now; what was to come is forgotten
  kFree,           ///< lets go
  kServoJoints,    ///< servo_jp
  kServoJointsBy,  ///< servo_jr: from the set point; every one counts
  kServoPose,      ///< servo_cp
  kServoPoseBy,    ///< servo_cr: `pose_B` moved by and turned by in B, from the set point; every one counts
  kServoTwist,     ///< servo_cv: until the next, or a time-out
  kMoveJoints,     ///< move_jp
  kMovePose,       ///< move_cp
  kServoJaw,       ///< jaw/servo_jp
  kServoJawBy,     ///< jaw/servo_jr
  kMoveJaw,        ///< jaw/move_jp
  kServoRates,     ///< servo_jv: rates of the joints, until the next, or a time-out
  kMoveJointsBy,   ///< move_jr: from where the newest move or servo command leads
  kMoveJawBy,      ///< jaw/move_jr
  kServoForces,    ///< servo_jf: torques and forces on the joints, of the model alone
  kServoWrench,    ///< servo_cf: force and torque at the tip, of the model alone
  kServoJawForce,  ///< jaw/servo_jf
  kRatio,          ///< trajectory_j/set_ratio: `number` of move_speed and move_turn_rate, for the moves that begin then
  kGravity,        ///< use_gravity_compensation: while forces are asked for, `number` 0 leaves the arm its weight
  kTool,           ///< emulate_tool_present: a Raven does not look for its tool
  kEndTwist,       ///< who asked for a twist, rates or forces is gone: they end
};
constexpr std::size_t kServoKindCount = 23;
constexpr std::array<const char*, kServoKindCount> kServoKindNames{"state_command",
                                                                   "hold",
                                                                   "free",
                                                                   "servo_jp",
                                                                   "servo_jr",
                                                                   "servo_cp",
                                                                   "servo_cr",
                                                                   "servo_cv",
                                                                   "move_jp",
                                                                   "move_cp",
                                                                   "jaw/servo_jp",
                                                                   "jaw/servo_jr",
                                                                   "jaw/move_jp",
                                                                   "servo_jv",
                                                                   "move_jr",
                                                                   "jaw/move_jr",
                                                                   "servo_jf",
                                                                   "servo_cf",
                                                                   "jaw/servo_jf",
                                                                   "trajectory_j/set_ratio",
                                                                   "use_gravity_compensation",
                                                                   "emulate_tool_present",
                                                                   "left"};

/** Where a wrench of servo_cf acts, and along which axes. */
enum class WrenchFrame : std::uint8_t {
  kTip,     ///< at the tip T, along the axes of B
  kBody,    ///< at T, along its own axes
  kOrigin,  ///< torque about the origin of B, along its axes
};

/** Joints of an arm without its jaws: shoulder to wrist, then the jaws' mid-line (kinematics::jawMidline). */
constexpr std::size_t kServoJointCount = 6;
using ServoJoints = std::array<double, kServoJointCount>;  ///< [rad; m for kInsertion] DH convention (raven2.md 2.3)

/** One message of a client. Frame B is the arm's base. */
struct ServoCommand {
  std::uint32_t id{};  ///< chosen by the sender: ServoRefused::id
  ServoKind kind{ServoKind::kHold};
  StateCommand state{StateCommand::kEnable};  ///< kState
  Arm arm{Arm::kGold};
  std::uint8_t is_shoulder{};  ///< kServoJoints: 1 of `joints` the first alone counts, the others stay where they lead
  ServoJoints joints{};        ///< positions, how far from the set point, rates, or torques and forces
  RigidPose pose_B{};          ///< of the tool tip T in B, or how far from the set point
  Vec3 v_B{}, w_B{};           ///< [m/s], [rad/s] kServoTwist, of T in B
  Vec3 force{}, torque{};      ///< [N], [Nm] kServoWrench
  WrenchFrame frame{WrenchFrame::kTip};
  double jaw{};     ///< [rad] the jaws' opening (kinematics::jawOpening), or how far from the set point; [Nm] on it
  double number{};  ///< kRatio, kGravity, kTool
};
static_assert(std::is_trivially_copyable<ServoCommand>::value, "travels in a ring");

/** Why a command did nothing. */
enum class ServoRefusal : std::uint8_t {
  kNone,
  kInvalid,       ///< the state table has no such command in this state
  kNotEnabled,    ///< not ENABLED
  kNotHomed,      ///< the robot is not ready to move
  kConsole,       ///< the surgeon's console has the pedal down
  kMode,          ///< planning, a trial, a replay: something that ends first
  kRobotStop,     ///< the robot is in E-STOP: that is ended at the robot
  kOperatorStop,  ///< an operator stopped the arms: the operator clears that
  kNotFinite,     ///< a number is NaN or infinite, or a rotation is invalid
  kOutOfRange,    ///< a joint or the jaws beyond its limits: `value`, `limit`, `joint`
  kTooFar,        ///< farther from the set point than a servo command may lead: `value`, `limit`; move_* goes there
  kTooFast,       ///< kServoTwist, kServoRates: `value`, `limit`
  kUnreachable,   ///< a pose without joints for it
  kQueueFull,     ///< more moves wait than are kept
  kNotOffered,    ///< a Raven cannot: unhome, a tool that is looked for
  kHasRobot,      ///< a force, and a robot is there: its controllers hold positions
  kTooStrong,     ///< kServoForces, kServoWrench, kServoJawForce: `value`, `limit`, `joint`
  kNoRatio,       ///< kRatio beyond 0.001 to 1: `value`
};
constexpr std::size_t kServoRefusalCount = 18;

/** One for each command that did nothing. */
struct ServoRefused {
  std::uint32_t id{};
  ServoKind kind{ServoKind::kHold};
  StateCommand state{StateCommand::kEnable};
  ServoRefusal reason{ServoRefusal::kNone};
  OperatingState in{OperatingState::kDisabled};
  Arm arm{Arm::kGold};
  std::uint8_t joint{};    ///< kOutOfRange, kTooStrong: 0 to 5 of ServoJoints, 6 the jaws
  std::uint8_t is_turn{};  ///< kTooFar, kTooFast, kTooStrong: 1 `value` of a rotation [rad; Nm], 0 of a length [m; N]
  double value{}, limit{};
};
static_assert(std::is_trivially_copyable<ServoRefused>::value, "travels in a ring");

/** State of an arm for its clients. */
struct ServoArmState {
  std::uint8_t is_busy{};    ///< a move_* or homing is under way
  RigidPose setpoint_B{};    ///< of T: what the arm's controllers are asked for
  ServoJoints setpoint_q{};  ///< the same in joints
  double setpoint_jaw{};     ///< [rad]
  RigidPose goal_B{};        ///< where the newest move or servo command leads; the set point if none
  double ratio{1.0};         ///< of move_speed and move_turn_rate that moves begin with
  std::uint32_t run_out{};   ///< twists and rates that ended by their time-out, since the start
};

/** The end of tick `tick`. Both arms have one operating state: the Raven has one run level. */
struct ServoState {
  Tick tick{-1};
  std::int64_t time_ns{};  ///< ModelState::time_ns of the tick
  OperatingState state{OperatingState::kDisabled};
  std::uint8_t is_homed{};
  std::uint8_t holds_pedal{};  ///< 1 while a client moves the arms, 0 nobody or the console
  std::uint8_t alone{};        ///< 1 while a client moves the model without the robot that was there before
  PerArm<ServoArmState> arms{};
  std::uint64_t received{}, applied{}, refused{};  ///< commands; received = applied + refused
};
static_assert(std::is_trivially_copyable<ServoState>::value, "crosses threads word by word");

}  // namespace raven2_trainer
