#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// What a CRTK client (Collaborative Robotics Toolkit) asks of the arms, and what it is told. The arms are moved as by a
// master: what is asked for becomes increments and a pedal, so that model, robot, faults and the log take it as theirs.

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
};
constexpr std::size_t kServoKindCount = 13;
constexpr std::array<const char*, kServoKindCount> kServoKindNames{
    "state_command", "hold",    "free",    "servo_jp",     "servo_jr",     "servo_cp",   "servo_cr",
    "servo_cv",      "move_jp", "move_cp", "jaw/servo_jp", "jaw/servo_jr", "jaw/move_jp"};

/** Joints of an arm without its jaws: shoulder to wrist, then the jaws' mid-line (kinematics::jawMidline). */
constexpr std::size_t kServoJointCount = 6;
using ServoJoints = std::array<double, kServoJointCount>;  ///< [rad; m for kInsertion] DH convention (raven2.md 2.3)

/** One message of a client. Frame B is the arm's base. */
struct ServoCommand {
  std::uint32_t id{};  ///< chosen by the sender: ServoRefused::id
  ServoKind kind{ServoKind::kHold};
  StateCommand state{StateCommand::kEnable};  ///< kState
  Arm arm{Arm::kGold};
  ServoJoints joints{};  ///< positions, or how far from the set point
  RigidPose pose_B{};    ///< of the tool tip T in B, or how far from the set point
  Vec3 v_B{}, w_B{};     ///< [m/s], [rad/s] kServoTwist, of T in B
  double jaw{};          ///< [rad] the jaws' opening (kinematics::jawOpening), or how far from the set point
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
  kOperatorStop,  ///< an operator stopped the arms: whoever did clears that
  kNotFinite,     ///< a number that is none, or a turn that is none
  kOutOfRange,    ///< a joint or the jaws beyond its limits: `value`, `limit`, `joint`
  kTooFar,        ///< farther from the set point than a servo command may lead: `value`, `limit`; move_* goes there
  kTooFast,       ///< kServoTwist: `value`, `limit`
  kUnreachable,   ///< a pose without joints for it
  kQueueFull,     ///< more moves wait than are kept
  kNotOffered,    ///< a Raven cannot: unhome
};
constexpr std::size_t kServoRefusalCount = 15;

/** One for each command that did nothing. */
struct ServoRefused {
  std::uint32_t id{};
  ServoKind kind{ServoKind::kHold};
  StateCommand state{StateCommand::kEnable};
  ServoRefusal reason{ServoRefusal::kNone};
  OperatingState in{OperatingState::kDisabled};
  Arm arm{Arm::kGold};
  std::uint8_t joint{};    ///< kOutOfRange: 0 to 5 of ServoJoints, 6 the jaws
  std::uint8_t is_turn{};  ///< kTooFar, kTooFast: 1 `value` is an angle [rad], 0 a length [m]
  double value{}, limit{};
};
static_assert(std::is_trivially_copyable<ServoRefused>::value, "travels in a ring");

/** How an arm stands to its clients. */
struct ServoArmState {
  std::uint8_t is_busy{};    ///< a move_* or homing is under way
  RigidPose setpoint_B{};    ///< of T: what the arm's controllers are asked for
  ServoJoints setpoint_q{};  ///< the same in joints
  double setpoint_jaw{};     ///< [rad]
  RigidPose goal_B{};        ///< where the newest move or servo command leads; the set point if none
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
