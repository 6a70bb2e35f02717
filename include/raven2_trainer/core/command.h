#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// Elements of the rings between threads (core/spsc_ring.h): each one counts, not only the newest.

namespace raven2_trainer {

// Values of MasterCommand::pedal and ModelState::pedal while a pedal is down.
constexpr std::uint8_t kSurgeonsPedal = 1;
constexpr std::uint8_t kClientsPedal = 2;  ///< pedal of a CRTK client: its motion does not come from a hand

/** One accepted ITP packet of the masters, or the CRTK clients' motion in one tick. The increments are already scaled,
 * because ITP has no motion scale. */
struct MasterCommand {
  std::uint32_t sequence{};
  std::uint8_t pedal{};                               ///< 0 up; kSurgeonsPedal: surgeon_mode != 0; kClientsPedal
  PerArm<Vec3> dp_I{};                                ///< [m] [@frame I] position increment
  PerArm<Quat> dq_I{{kIdentityQuat, kIdentityQuat}};  ///< [@frame I] rotation increment, left-multiplied
  PerArm<double> dgrasp{};                            ///< [rad] grasp increment, positive closes
};

/** Packet to the robot in one tick. If the robot must not move: pedal up, no increments. */
struct RelayPacket {
  Tick tick{};
  MasterCommand command{};     ///< `sequence` counts the packets to the robot
  std::uint32_t impairment{};  ///< bad network: 1 + index in LoopConfig::impairments; 0: no bad network
  std::uint8_t is_held{};      ///< 1: no faults (real robot); a bad network's delayed packets are discarded
};

/** Force for the console, one packet per haptic tick. */
struct ForcePacket {
  std::uint32_t sequence{};
  std::uint32_t last_sequence{};  ///< newest packet sequence that the robot reported
  std::uint8_t runlevel{};
  PerArm<Vec3> force_I{};  ///< [N] [@frame I]
};

/** Requests to the physics loop, from ROS services and pedals. */
enum class RequestKind : std::uint8_t {
  kNone,
  kEngage,     ///< the robot follows from the next pedal-down on
  kDisengage,  ///< the robot stops following at once
  kPlan,
  kCancelPlan,  ///< ends goal selection, planning and execution, and deletes the plan
  kSetCollisions,
  kBeginPlanning,    ///< planning mode: the masters move only the model's `arm`, to show the goal
  kRecordGoal,       ///< the arm's present joints become the goal; the arm returns to its start, and the planner starts
  kEndPlanning,      ///< the arm returns to its start without a plan
  kExecutePlan,      ///< arms the plan: the next pedal-down starts it, and it runs while the pedal is held
  kBeginSimulation,  ///< the masters move only the model
  kEndSimulation,    ///< the model returns to the robot's joints
  kBeginTrial,       ///< virtual trial: like simulation, and the motion is recorded
  kEndTrial,         ///< ends the trial and keeps its motion
  kDiscardTrial,     ///< deletes the trial's motion
  kRepeatTrial,      ///< arms the trial's motion, as kExecutePlan a plan
  kEmergencyStop,
  kClearStop,       ///< clears a stop caused by a request, a pedal, or a robot that is gone
  kSetView,         ///< `enabled`: 1 the real camera's image, 0 the virtual one
  kSetCameraPedal,  ///< `enabled`: a CameraPedal
  kToolChange,      ///< the tool of `arm` was changed
  kStartExercise,   ///< restarts: objects return to their start, timer and mistakes to zero
  kBeginReplay,     ///< the model shows a recorded session
  kEndReplay,
  kSetEffort,  ///< a CRTK client's forces on the model's `arm` (control/effort.h); only the daemon sends it
};
constexpr std::size_t kRequestKindCount = 25;
constexpr std::array<const char*, kRequestKindCount> kRequestKindNames{
    "none",           "engage",           "disengage",     "plan",           "cancel_plan",      "set_collisions",
    "begin_planning", "record_goal",      "end_planning",  "execute_plan",   "begin_simulation", "end_simulation",
    "begin_trial",    "end_trial",        "discard_trial", "repeat_trial",   "emergency_stop",   "clear_stop",
    "set_view",       "set_camera_pedal", "tool_change",   "start_exercise", "begin_replay",     "end_replay",
    "set_effort"};

/** Request::enabled of kSetCameraPedal. */
enum class CameraPedal : std::uint8_t {
  kReleased,
  kPressed,  ///< the masters move the camera
  kSilent,   ///< no message for too long: the camera stops, and the arms wait for a new pedal-down
};

/** Goal of a plan. */
enum class GoalKind : std::uint8_t {
  kDefault,  ///< the tip position in planner.yaml
  kTip,      ///< a tip position, orientation free
  kJoints,   ///< joint positions
};
constexpr std::size_t kGoalKindCount = 3;
constexpr std::array<const char*, kGoalKindCount> kGoalKindNames{"default", "tip", "joints"};

/** Request ids from 1 to this are the daemon's own: for its scripted requests, and for plans requested with id 0. */
constexpr std::uint32_t kOwnRequestIds = 999;

struct Request {
  RequestKind kind{RequestKind::kNone};
  Arm arm{Arm::kGold};
  std::uint8_t choose_arm{};  ///< kPlan: 1 the planner may choose the other arm if it suits the goal better
  std::uint8_t enabled{};     ///< kSetCollisions: 1 `arm` collides with scene and other arm, 0 it passes through;
                              ///< kSetEffort: kind and flags
  GoalKind goal{GoalKind::kDefault};
  std::uint8_t on_robot{};  ///< kExecutePlan, kRepeatTrial: 1 the robot moves too
  Vec3 goal_W{};            ///< [m] [@frame W] kTip
  JointArray goal_q{};      ///< [rad, m] kJoints: goal; of the jaws only the mid-line moves, the opening stays;
                            ///< [Nm; N] kSetEffort
  std::uint32_t id{};       ///< above kOwnRequestIds (SharedState::next_request); returned as PlanResult::id,
                            ///< PlanningState::answered and ExecutionReport::id; 0: no answer wanted
  std::uint32_t plan{};     ///< kExecutePlan: id of the plan; 0: the present plan. kBeginReplay: number that
                            ///< recording::SessionPlayer::open() returned
};

enum class FaultOrder : std::uint8_t {
  kClear,
  kArm,       ///< the fault waits for its trigger
  kArmAtOnce  ///< the fault acts now
};

/** Request to the fault director. */
struct FaultRequest {
  FaultOrder order{};
  std::uint32_t fault_id{};  ///< scenario, 1 + its index in the library (Fault::id of all its faults); kClear: 0 all
};

/** Planning problem for the planner thread. */
struct PlanRequest {
  std::uint32_t id{};
  std::uint32_t serial{};  ///< number of this problem; selects its flag in SharedState::plan_cancelled
  Arm arm{Arm::kGold};
  JointArray start{};         ///< [rad, m] joints of `arm`
  JointArray other{};         ///< [rad, m] joints of the other arm
  std::uint8_t choose_arm{};  ///< as Request::choose_arm
  GoalKind goal{GoalKind::kDefault};
  Vec3 goal_W{};        ///< [m] kTip
  JointArray goal_q{};  ///< [rad, m] kJoints
};

enum class PlanStatus : std::uint8_t {
  kNone,
  kSuccess,
  kStartInCollision,
  kGoalUnreachable,
  kGoalInCollision,
  kNoPath,              ///< no path through the samples, even after more were added; or over kMaxWaypoints
  kCancelled,           ///< by request, pedal or newer plan, or the request was refused
  kDynamicsInfeasible,  ///< paths exist, but a simulated arm that follows them touches something or lags too far
  kTimeLimit,           ///< the time limit passed without an answer
  kInvalidStart,        ///< start outside the joint limits, NaN or infinity
  kFailed,              ///< error inside the planner
};
constexpr std::size_t kPlanStatusCount = 11;
constexpr std::array<const char*, kPlanStatusCount> kPlanStatusNames{
    "none",    "success",   "start_in_collision",  "goal_unreachable", "goal_in_collision",
    "no_path", "cancelled", "dynamics_infeasible", "time_limit",       "invalid_start",
    "failed"};

constexpr std::size_t kMaxWaypoints = 64;

/** Answer of the planner. The arm stops at each waypoint, so that the cost is a sum over edges. */
struct PlanResult {
  std::uint32_t id{};
  PlanStatus status{PlanStatus::kNone};
  Arm arm{Arm::kGold};
  std::uint32_t waypoint_count{};
  std::array<JointArray, kMaxWaypoints> waypoints{};  ///< [rad, m] first is the start
  std::array<double, kMaxWaypoints> arrival{};        ///< [s] at each waypoint, from the start of the motion
  double cost{};                                      ///< eq. (1) of Li et al. 2017
  double planning_time{};                             ///< [s] wall clock; in lockstep the fixed simulated delay
  double clearance{};            ///< [m] least distance of a simulated arm on the path to anything, at most 0.05
  double tracking_error{};       ///< [m] greatest distance of its tip from the desired position
  std::uint32_t samples{};       ///< used, also those added after a failure; 0: OMPL does not report them
  std::uint8_t robot_follows{};  ///< 1: increments can lead the robot along the path (control::robotFollows())
};
static_assert(std::is_trivially_copyable<PlanResult>::value, "travels in a ring");

/** Maximum of unanswered plan requests; capacity of the rings to and from the planner. */
constexpr std::size_t kMaxPlansUnderWay = 4;

/** Why the execution of a plan ended. */
enum class ExecutionEnd : std::uint8_t {
  kNone,
  kFinished,    ///< at the goal and settled
  kReleased,    ///< the pedal went up
  kCancelled,   ///< by request: cancel, disengage, or another plan before pedal-down
  kEStop,       ///< emergency stop by request, pedal or robot, or the model failed
  kTimeSlip,    ///< simulated time was lost, or the session was paused
  kRobotLost,   ///< the robot's connection or homing was lost, it left PEDAL_DN, or did not follow in time
  kOffPath,     ///< model or robot was farther from the path than allowed
  kNotSettled,  ///< the path ended, but model or robot did not come to rest at the goal in time
  kNoPedal,     ///< armed, but no pedal-down in time
  kMoved,       ///< armed, but an arm moved between the plan's request and pedal-down
};
constexpr std::size_t kExecutionEndCount = 11;
constexpr std::array<const char*, kExecutionEndCount> kExecutionEndNames{
    "none",       "finished", "released",    "cancelled", "e_stop", "time_slip",
    "robot_lost", "off_path", "not_settled", "no_pedal",  "moved"};

/** Distance of a tool tip from its desired position on the path at the same instant. */
struct TrackingError {
  double mean{};     ///< [m] over the ticks from pedal-down to the end
  double largest{};  ///< [m] in those ticks
  double at_end{};   ///< [m] from the path's end, in the last tick
};

/** Result of an execution. Each armed plan or trial gets one. */
struct ExecutionReport {
  std::uint32_t id{};    ///< of the request to execute
  std::uint32_t plan{};  ///< id of the plan; 0: a trial
  Arm arm{Arm::kGold};
  std::uint8_t on_robot{};  ///< 1: the robot moved too
  ExecutionEnd end{ExecutionEnd::kNone};
  Tick started{-1};                ///< [1 ms] tick of the pedal-down; -1: no pedal-down
  Tick ended{-1};                  ///< [1 ms] first tick without motion
  double path_time{};              ///< [s] duration of the path at full speed
  double progress{};               ///< [-] elapsed share of the path's time at the end, 0 to 1
  double planned_clearance{};      ///< [m] PlanResult::clearance
  TrackingError model{};           ///< of the nominal model
  TrackingError robot{};           ///< of the robot, as received; zero if it did not move
  double model_clearance{};        ///< [m] least distance of the model's arm to anything, at most 0.05; 0: contact
  double robot_clearance{};        ///< [m] the same at the robot's joint positions; zero if the robot did not move
  std::uint32_t contact_ticks{};   ///< [1 ms] ticks with contacts of the model's arm; of a trial: either arm
  std::uint32_t contact_points{};  ///< most contact points in one tick; of a trial: sum of both arms
};
static_assert(std::is_trivially_copyable<ExecutionReport>::value, "crosses threads word by word");

}  // namespace raven2_trainer
