#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/mode.h"
#include "raven2_trainer/core/types.h"

// Structs that threads exchange through a StateCell (core/state_cell.h), which copies them word by word. So they hold
// only numbers and plain arrays. Joint coordinates are the robot's (raven2.md 2.3), not the URDF's:
// kinematics/joint_conventions.h converts.

namespace raven2_trainer {

/** Progress of planning and execution. The newest plan is kept as long as it may be executed. */
enum class PlanningStatus : std::uint8_t {
  kIdle,       ///< no plan
  kChoosing,   ///< the surgeon moves the model to the goal
  kPlanning,   ///< a plan is being computed
  kReady,      ///< the plan is ready; its execution is not requested
  kArmed,      ///< the next pedal-down starts the execution
  kExecuting,  ///< the plan is being executed
};
constexpr std::size_t kPlanningStatusCount = 6;
constexpr std::array<const char*, kPlanningStatusCount> kPlanningStatusNames{"idle",  "choosing", "planning",
                                                                             "ready", "armed",    "executing"};

/** Answer to a request for planning or execution. */
enum class PlanningAnswer : std::uint8_t {
  kNone,
  kAccepted,
  kNotNow,             ///< not in this mode, or the pedal is down
  kNoPlan,             ///< no plan, or not the requested one
  kMoved,              ///< an arm has moved since the plan was requested
  kNoRobot,            ///< for `on_robot`: no fresh state of a homed robot, or the daemon is disengaged
  kRobotCannotFollow,  ///< the robot's own inverse kinematics would leave the path
};
constexpr std::size_t kPlanningAnswerCount = 7;
constexpr std::array<const char*, kPlanningAnswerCount> kPlanningAnswerNames{
    "none", "accepted", "not_now", "no_plan", "moved", "no_robot", "robot_cannot_follow"};

/** Answer to request `id`. */
struct RequestAnswer {
  std::uint32_t id{};
  PlanningAnswer answer{PlanningAnswer::kNone};
  Mode mode{Mode::kWaiting};  ///< only of a pause: the mode after it
};

/** Planning and execution at the end of one tick. */
struct PlanningState {
  PlanningStatus status{PlanningStatus::kIdle};
  Arm arm{Arm::kGold};                           ///< arm of the goal selection or the plan
  std::uint8_t on_robot{};                       ///< kArmed, kExecuting: 1 if the robot moves too; else 0
  PlanningAnswer answer{PlanningAnswer::kNone};  ///< to the request `answered`
  std::uint32_t answered{};                      ///< Request::id of the newest that was answered
  std::uint32_t plan{};                          ///< id of the plan from kPlanning on; 0: no plan
  double progress{};                             ///< [-] kExecuting: elapsed share of the path's time, 0 to 1
};

/** Run level of the Raven's state machine (raven2.md 4.3). */
enum class RunLevel : std::uint8_t { kEStop = 0, kInit = 1, kPedalUp = 2, kPedalDown = 3 };
constexpr std::array<const char*, 4> kRunLevelNames{"E-STOP", "INIT", "PEDAL_UP", "PEDAL_DN"};

/** Joint and tool-tip state of one arm of the nominal model at the end of one physics step. */
struct ArmState {
  JointArray q{};             ///< [rad; m for kInsertion] joint position
  JointArray dq{};            ///< [rad/s; m/s for kInsertion] joint velocity
  JointArray tau{};           ///< [Nm; N for kInsertion] torque applied in this step
  JointArray q_d{};           ///< [rad; m for kInsertion] desired joint position
  Vec3 p_BT{};                ///< [m] tool tip in the arm base frame
  Vec3 v_BT{};                ///< [m/s] its velocity
  Quat q_BT{kIdentityQuat};   ///< tool orientation in the arm base frame
  std::uint32_t ik_status{};  ///< kinematics::IkStatus of this tick
  std::uint32_t contacts{};   ///< contact points on this arm in this step
};

/** Faults that the daemon applies in one tick. Bit i of a mask is 1 while FaultPlan::faults[i] acts. */
struct DaemonFaults {
  std::uint32_t active{};                 ///< Fault::id of one that acts, in the order relay, master, console; 0: no
  std::uint8_t relay{};                   ///< mask of faults on the stream to the robot
  std::uint8_t master{};                  ///< mask of faults on the masters' stream
  std::uint8_t console{};                 ///< mask of faults on the surgeon's force and image
  std::uint8_t picture{};                 ///< PictureFault that a fault of variable kPicture sets; 0: no fault
  std::uint32_t picture_delay_ms{};       ///< [ms] set by kPictureDelay
  PerArm<double> force_gain{{1.0, 1.0}};  ///< [-] set by kForceGain
  PerArm<Vec3> force_offset_B{};          ///< [N] set by kForceOffset
  FaultSignals signals{};                 ///< inputs of triggers
};

/** Pose of the movable camera. Its field of view is in the configuration (CameraConfig). */
struct CameraState {
  Vec3 eye_W{};                ///< [m]
  Vec3 target_W{};             ///< [m] point in the image's centre
  Vec3 up_W{{0.0, 0.0, 1.0}};  ///< [-]
};

/** The nominal model at the end of tick `tick`. */
struct ModelState {
  Tick tick{};             ///< [1 ms] step that produced this state
  Tick session_tick{-1};   ///< [1 ms] since the first pedal down; -1 before
  std::int64_t time_ns{};  ///< [ns] CLOCK_MONOTONIC at the start of the tick; in lockstep tick x 1e6
  Mode mode{Mode::kWaiting};
  std::uint8_t pedal{};        ///< 1 while the surgeon's pedal is down, 2 while a CRTK client's is (core/command.h)
  std::uint8_t engaged{1};     ///< 1 while the daemon sends the surgeon's motion to the robot
  std::uint8_t robot_fresh{};  ///< 1 while the robot is connected and its state at most 20 ms old
  std::uint8_t linked{};       ///< 1 while the same commands move model and robot, from a common pose; else no force
  std::uint32_t commands_used{};  ///< master commands that moved the model in this tick
  std::uint32_t guide_plan{};     ///< id of the plan whose path may guide the hand; 0: no plan
  PerArm<Vec3> master_I{};      ///< [m] [@frame I] sum of all increments of the masters, used or not; clients' excluded
  PlanningState planning{};     ///< progress of planning and execution
  ExerciseState exercise{};     ///< progress of the exercise
  CameraState camera{};         ///< pose of the movable camera
  std::uint32_t pedals{};       ///< bit(Pedal::kCamera) while the masters move the camera; other bits are 0
  std::uint32_t trial_ticks{};  ///< [1 ms] length of the recorded virtual trial
  std::uint8_t view{};          ///< 1: the real camera's image is selected
  DaemonFaults faults{};        ///< effects in the daemon
  PerArm<ArmState> arms{};
  std::array<RigidPose, kMaxSceneBodies> bodies{};  ///< in W: free bodies, then breakables, in SceneModel order
};
static_assert(std::is_trivially_copyable<ModelState>::value, "crosses threads word by word");

/** The robot's `jstate` (raven2.md 4.4): 0 not_ready, 1 pos_unknown, 2 homing1, 3 homing2, 4 ready, 5 wait, 6
 * hard_stop. */
constexpr std::uint8_t kMaxJointState = 6;
constexpr std::uint8_t kJointStateUnknown = 255;  ///< the robot does not report it
constexpr std::array<std::uint8_t, kJointCount> kNoJointStates{255, 255, 255, 255, 255, 255, 255};

/** Whether the robot's control program runs. Faults can stop it. */
enum class ProgramState : std::uint8_t { kRunning, kHung, kCrashed };

/** One arm of the robot as received. */
struct RobotArmState {
  JointArray q{};                               ///< [rad; m for kInsertion]
  JointArray dq{};                              ///< [rad/s; m/s for kInsertion]
  JointArray motor{};                           ///< [rad] motor position
  std::array<std::int32_t, kJointCount> dac{};  ///< [counts] last command, after the robot's clipping and after faults
  std::array<std::uint8_t, kJointCount> jstate = kNoJointStates;  ///< homing state of each joint
  Vec3 p_BT{};                                                    ///< [m] tool tip by forward kinematics of `q`
  Vec3 v_BT{};                                                    ///< [m/s] J dq (paper, eq. 3)
};

/** The robot, from its newest state frame. */
struct RobotState {
  std::uint64_t cycle{};          ///< robot control cycle that sent the frame
  std::uint64_t frame{};          ///< frames applied on this connection; 0: the robot's data are not valid yet
  std::int64_t time_ns{};         ///< [ns] the robot computer's CLOCK_MONOTONIC in that cycle; in lockstep tick x 1e6
  std::int64_t received_ns{};     ///< [ns] CLOCK_MONOTONIC at receipt minus wire::FrameDelay; in lockstep tick x 1e6
  std::uint32_t last_sequence{};  ///< ITP sequence number that the robot stores as its last
  std::uint32_t active_fault{};   ///< Fault::id acting in that cycle; 0: no fault
  RunLevel runlevel{RunLevel::kEStop};
  std::uint8_t sublevel{};
  std::uint8_t connected{};  ///< 1 while the TCP link is up
  std::uint8_t homed{};
  std::uint8_t soft_estopped{};
  std::uint8_t fault_mask{};                     ///< bit i: FaultPlan::faults[i] acts in that cycle
  ProgramState program{ProgramState::kRunning};  ///< known in lockstep only: a stopped program sends no frame
  std::uint8_t is_virtual{};                     ///< 1 only if the hello said "virtual"; anything else is a real robot
  PerArm<RobotArmState> arms{};
  LinkCounts itp{};  ///< the robot's own count of our packets
};
static_assert(std::is_trivially_copyable<RobotState>::value, "crosses threads word by word");

/** Forces on the hands in one tick. Re-simulation computes them from earlier ticks and both states, model and robot. */
struct HapticState {
  Tick tick{-1};                    ///< model tick it was computed from
  std::uint64_t count{};            ///< haptic ticks so far
  std::uint64_t robot_cycle{};      ///< robot cycle it was computed from
  std::int64_t time_ns{};           ///< [ns] CLOCK_MONOTONIC of the tick; in lockstep tick x 1e6
  PerArm<Vec3> force_B{};           ///< [N] in each arm's frame B
  PerArm<Vec3> force_I{};           ///< [N] the same in master (ITP) axes
  PerArm<double> error{};           ///< [m] distance of model and robot tips; 0 if either is not finite
  PerArm<Vec3> cue_B{};             ///< [N] wanted by eqs. (5) and (6)
  PerArm<Vec3> guidance_B{};        ///< [N] wanted by the guidance along a path
  PerArm<Vec3> edge_B{};            ///< [N] wanted at the edge of the master's workspace
  PerArm<double> gain{{1.0, 1.0}};  ///< [-] share of the cue that the passivity controller allows
  PerArm<double> energy{};          ///< [J] given to the hand by all forces, minus what they take back (haptics.md: M)
  PerArm<double> allowance{};       ///< [J] limit of `energy`; both determine the share of guidance and edge
  PerArm<double> guidance_fade{};   ///< [-] 0 no guidance to 1 full guidance
  PerArm<Vec3> master_I{};          ///< [m] ModelState::master_I of `tick`
  PerArm<Vec3> hand_I{};            ///< [m] hand position from the assumed middle of its workspace
  std::uint32_t guide_plan{};       ///< id of the plan whose path can guide the hand; 0: no path, or guidance is off
  std::uint8_t pedal{};             ///< ModelState::pedal of `tick`
  std::uint8_t active{};            ///< 1 while forces may act: linked, model and robot fresh; else forces fall to 0
};
static_assert(std::is_trivially_copyable<HapticState>::value, "crosses threads word by word");

}  // namespace raven2_trainer
