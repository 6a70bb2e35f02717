#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// Commands of CRTK clients (Collaborative Robotics Toolkit, doc/crtk.md) to the arms, and states of the arms for the
// clients. In each tick, motion commands become increments and a pedal state, like those of a master. So model, robot,
// faults and log treat both alike. Forces become requests (control/effort.h).

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

/** Commands. The goal of a servo command stays in force, also when it is reached. It ends with the next motion or force
 * command for the same part (six joints, or jaws), a hold, or a stop: pedal up, camera pedal, no path to the goal. */
enum class ServoKind : std::uint8_t {
  kState,          ///< ServoCommand::state
  kHold,           ///< stays at the set point; discards all motion and forces
  kFree,           ///< as StateCommand::kPause: the brakes hold the arm
  kServoJoints,    ///< servo_jp
  kServoJointsBy,  ///< servo_jr: relative to the goal in force of servo_jp or servo_jr, else to the set point;
                   ///< steps add up
  kServoPose,      ///< servo_cp
  kServoPoseBy,    ///< servo_cr: translation and rotation in B, relative to the goal in force of servo_cp or
                   ///< servo_cr, else to the set point
  kServoTwist,     ///< servo_cv: twist of the tip, until the next motion or twistTimeout() (control/crtk_config.h)
  kMoveJoints,     ///< move_jp
  kMovePose,       ///< move_cp
  kServoJaw,       ///< jaw/servo_jp
  kServoJawBy,     ///< jaw/servo_jr: relative to the goal in force of jaw/servo_*, else to the set point's opening
  kMoveJaw,        ///< jaw/move_jp
  kServoRates,     ///< servo_jv: joint rates; ends like kServoTwist
  kMoveJointsBy,   ///< move_jr: relative to the end of the queued moves, else as servo_jr
  kMoveJawBy,      ///< jaw/move_jr: relative to the end of a jaw/move_* under way, else as jaw/servo_jr
  kServoForces,    ///< servo_jf: torques and forces on the joints; only on the model, like the next two
  kServoWrench,    ///< servo_cf: force and torque at the tip
  kServoJawForce,  ///< jaw/servo_jf
  kRatio,          ///< trajectory_j/set_ratio: `number` times move_speed and move_turn_rate, of moves not begun
  kGravity,        ///< use_gravity_compensation: `number` 0: forces act without gravity compensation
  kTool,           ///< emulate_tool_present: always refused
  kEndTwist,       ///< a node that published servo_cv has gone: the twist ends
  kEndRates,       ///< the same of servo_jv
  kEndForces,      ///< the same of servo_jf, servo_cf or jaw/servo_jf
};
constexpr std::size_t kServoKindCount = 25;
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
                                                                   "left servo_cv",
                                                                   "left servo_jv",
                                                                   "left servo_jf"};

/** Where a wrench of servo_cf acts, and along which axes. */
enum class WrenchFrame : std::uint8_t {
  kTip,     ///< at the tip T, along the axes of B
  kBody,    ///< at T, along the axes of T
  kOrigin,  ///< along the axes of B, with the torque about B's origin
};

/** Joints of an arm except its jaws' opening, in the robot's own coordinates (raven2.md 2.3): shoulder to wrist, then
 * the jaws' mid-line (kinematics::jawMidline). */
constexpr std::size_t kServoJointCount = 6;
using ServoJoints = std::array<double, kServoJointCount>;  ///< [rad; m for kInsertion]

/** One command of a client. Frame B is the arm's base; T is the tool tip. */
struct ServoCommand {
  std::uint32_t id{};  ///< of the sender's choice; a refusal repeats it
  ServoKind kind{ServoKind::kHold};
  StateCommand state{StateCommand::kEnable};  ///< kState
  Arm arm{Arm::kGold};
  std::uint8_t is_shoulder{};  ///< kServoJoints: 1: only joints[0], the shoulder, counts; others keep their goals
  ServoJoints joints{};        ///< by kind: positions, steps, rates, or torques and forces
  RigidPose pose_B{};          ///< pose of T in B, or a step
  Vec3 v_B{}, w_B{};           ///< [m/s], [rad/s] kServoTwist, of T in B
  Vec3 force{}, torque{};      ///< [N], [Nm] kServoWrench
  WrenchFrame frame{WrenchFrame::kTip};
  double jaw{};     ///< [rad] opening (kinematics::jawOpening), or a step; kServoJawForce: [Nm] > 0 opens
  double number{};  ///< kRatio, kGravity, kTool
};
static_assert(std::is_trivially_copyable<ServoCommand>::value, "travels in a ring");

/** Why a command was refused. */
enum class ServoRefusal : std::uint8_t {
  kNone,
  kInvalid,       ///< the state table has no such command in this state
  kNotEnabled,    ///< not ENABLED
  kNotHomed,      ///< the robot is not ready to move
  kConsole,       ///< the surgeon's console has the pedal down
  kMode,          ///< another activity must end first: a plan, a trial, a replay
  kRobotStop,     ///< the robot is in E-STOP or being started: act at the robot
  kOperatorStop,  ///< an operator stopped the arms: only clear_stop ends that
  kNotFinite,     ///< a number is NaN or infinite, or a rotation is invalid
  kOutOfRange,    ///< a joint or the jaws beyond the limits: `value`, `limit`, `joint`
  kTooFar,        ///< a servo goal too far from the set point: `value`, `limit`; use move_*
  kTooFast,       ///< kServoTwist, kServoRates: `value`, `limit`
  kUnreachable,   ///< no inverse solution at the goal or on the path
  kQueueFull,     ///< eight moves are queued
  kNotOffered,    ///< unhome (except in dialect `raven`), emulate_tool_present
  kHasRobot,      ///< a force or kGravity, but a robot is connected: its controllers hold positions
  kTooStrong,     ///< a force beyond a joint controller's limit: `value`, `limit`, `joint`
  kNoRatio,       ///< kRatio beyond 0.001 to 1: `value`
};
constexpr std::size_t kServoRefusalCount = 18;

/** Report of a refused command. */
struct ServoRefused {
  std::uint32_t id{};
  ServoKind kind{ServoKind::kHold};
  StateCommand state{StateCommand::kEnable};
  ServoRefusal reason{ServoRefusal::kNone};
  OperatingState in{OperatingState::kDisabled};
  Arm arm{Arm::kGold};
  std::uint8_t joint{};    ///< kOutOfRange, kTooStrong: 0 to 5 of ServoJoints, 6 the jaws
  std::uint8_t is_turn{};  ///< 1: `value` in rad, rad/s or Nm; 0: m, m/s, N or no unit
  double value{}, limit{};
};
static_assert(std::is_trivially_copyable<ServoRefused>::value, "travels in a ring");

/** State of an arm for its clients. */
struct ServoArmState {
  std::uint8_t is_busy{};    ///< a move_* or the robot's homing is under way
  RigidPose setpoint_B{};    ///< of T: goal of the arm's controllers, without the trim (doc/crtk.md)
  ServoJoints setpoint_q{};  ///< the same in joints
  double setpoint_jaw{};     ///< [rad]
  RigidPose goal_B{};        ///< goal of the newest move or servo command; without one the set point
  double ratio{1.0};         ///< factor on move_speed and move_turn_rate of new moves
  std::uint32_t run_out{};   ///< twists, rates and forces that timed out, since the start
  std::uint32_t moves{};     ///< accepted move_* of arm or jaws, since the start
  std::uint32_t ended{};     ///< motions that met a limit, or a pose without joint positions, on their path
};

/** State at the end of tick `tick`. Both arms share one operating state, because a Raven has one run level. */
struct ServoState {
  Tick tick{-1};
  std::int64_t time_ns{};  ///< ModelState::time_ns of the tick
  OperatingState state{OperatingState::kDisabled};
  std::uint8_t is_homed{};
  std::uint8_t holds_pedal{};  ///< 1: a client holds the pedal; 0: the console or nobody
  std::uint8_t alone{};        ///< 1: a client moves only the model, though a robot was connected before
  PerArm<ServoArmState> arms{};
  std::uint64_t received{}, applied{}, refused{};  ///< commands; received = applied + refused
};
static_assert(std::is_trivially_copyable<ServoState>::value, "crosses threads word by word");

}  // namespace raven2_trainer
