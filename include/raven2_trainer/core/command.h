#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// Elements of rings: each counts, none may be lost or seen twice.

namespace raven2_trainer {

// MasterCommand::pedal, ModelState::pedal: whose it is while it is down.
constexpr std::uint8_t kSurgeonsPedal = 1;
constexpr std::uint8_t kClientsPedal = 2;  ///< of a CRTK client: what it moves, no hand moved

/** One accepted ITP packet of the masters, or what CRTK clients ask for in a tick. Increments are already scaled by the
 * master (ITP has no scale). */
struct MasterCommand {
  std::uint32_t sequence{};
  std::uint8_t pedal{};                               ///< 0 up; kSurgeonsPedal: surgeon_mode != 0; kClientsPedal
  PerArm<Vec3> dp_I{};                                ///< [m] [@frame I] position increment
  PerArm<Quat> dq_I{{kIdentityQuat, kIdentityQuat}};  ///< [@frame I] incremental orientation
  PerArm<double> dgrasp{};                            ///< [rad] grasp increment, positive closes
};

/** The relay's packet to the robot for one tick: the increments that the model applied. */
struct RelayPacket {
  Tick tick{};
  MasterCommand command{};     ///< sequence is the relay's own
  std::uint32_t impairment{};  ///< 1 + position of the bad network it goes through, 0 none
  std::uint8_t is_held{};      ///< 1: no fault may touch what is sent, and nothing that one held back may come after it
};

/** Force for the console, one a haptic tick. */
struct ForcePacket {
  std::uint32_t sequence{};
  std::uint32_t last_sequence{};  ///< newest master packet applied
  std::uint8_t runlevel{};
  PerArm<Vec3> force_I{};  ///< [N] [@frame I]
};

/** Orders from operators (ROS services, schedules) to the physics loop. */
enum class RequestKind : std::uint8_t {
  kNone,
  kEngage,
  kDisengage,
  kPlan,
  kCancelPlan,  ///< gives up choosing, planning and executing, and forgets the plan
  kSetCollisions,
  kBeginPlanning,    ///< planning mode: the masters move `arm` of the model alone, until the next two
  kRecordGoal,       ///< where that arm is now is the goal: it goes back to where it was, and a plan is made
  kEndPlanning,      ///< it goes back to where it was, and no plan is made
  kExecutePlan,      ///< the plan that is there, from the next pedal-down on while the pedal is held
  kBeginSimulation,  ///< the masters move the model alone
  kEndSimulation,    ///< the model goes back to the robot
  kBeginTrial,       ///< a virtual trial: as simulation, and what the model does is kept
  kEndTrial,         ///< it is over
  kDiscardTrial,     ///< and forgotten
  kRepeatTrial,      ///< from the next pedal-down on while the pedal is held, on the robot too if `on_robot`
  kEmergencyStop,
  kClearStop,       ///< of an emergency stop by request or pedal
  kSetView,         ///< `enabled`: 1 the real camera's picture, 0 the virtual one
  kSetCameraPedal,  ///< `enabled`: a CameraPedal
  kToolChange,      ///< the tool of `arm` was changed
  kStartExercise,   ///< again: scene and arms' objects back to where they were, timer and mistakes at nothing
  kBeginReplay,     ///< the model shows a recorded session
  kEndReplay,
  kSetEffort,  ///< of a CRTK client, to `arm` of the model (control/effort.h); asked for within the daemon only
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
  kSilent,   ///< nothing was heard of it for too long: it counts as up, but nobody lifted a foot to go on with the arms
};

/** Where a plan shall lead. */
enum class GoalKind : std::uint8_t {
  kDefault,  ///< the goal of planner.yaml, a tip position
  kTip,      ///< a tip position, orientation free
  kJoints,   ///< joint positions
};
constexpr std::size_t kGoalKindCount = 3;
constexpr std::array<const char*, kGoalKindCount> kGoalKindNames{"default", "tip", "joints"};

/** Request::id up to this are the daemon's own: of its schedule, and of plans that pedals ask for. */
constexpr std::uint32_t kOwnRequestIds = 999;

struct Request {
  RequestKind kind{RequestKind::kNone};
  Arm arm{Arm::kGold};
  std::uint8_t choose_arm{};  ///< kPlan: 1 the planner chooses the arm from the goal, `arm` does not count
  std::uint8_t enabled{};     ///< kSetCollisions: 1 the arm meets scene and other arm, 0 it passes through;
                              ///< kSetEffort: which
  GoalKind goal{GoalKind::kDefault};
  std::uint8_t on_robot{};  ///< kExecutePlan: 1 the robot moves too
  Vec3 goal_W{};            ///< [m] [@frame W] kTip
  JointArray goal_q{};      ///< [rad, m] kJoints; the jaws keep the opening they have, their mid-line counts;
                            ///< [Nm; N] kSetEffort
  std::uint32_t id{};       ///< chosen by the sender: PlanResult::id, PlanningState::answered, ExecutionReport::id; 0:
                            ///< no answer is wanted, and a plan gets one of kOwnRequestIds
  std::uint32_t plan{};     ///< kExecutePlan: id of the plan that is meant; 0 whichever is there. kBeginReplay: what
                            ///< recording::SessionPlayer::open() gave
};

enum class FaultOrder : std::uint8_t {
  kClear,
  kArm,      ///< it waits for its own trigger
  kArmAtOnce
};

/** Orders to the fault director. */
struct FaultRequest {
  FaultOrder order{};
  std::uint32_t fault_id{};  ///< index in the scenario library + 1; 0 with kClear clears all
};

/** Problem handed to the planner thread. */
struct PlanRequest {
  std::uint32_t id{};
  std::uint32_t serial{};  ///< counts what the planner is asked: SharedState::plan_cancelled
  Tick requested_tick{};
  Arm arm{Arm::kGold};
  JointArray start{};         ///< [rad, m] the arm
  JointArray other{};         ///< [rad, m] the other arm
  std::uint8_t choose_arm{};  ///< 1: `arm` and `other` change places if the other one suits the goal better
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
  kNoPath,              ///< none through the samples, however many were added
  kCancelled,           ///< by request, by the pedal, or refused
  kDynamicsInfeasible,  ///< paths were found, but the arm touches something when it follows them
  kTimeLimit,           ///< the time was up before there was an answer
  kInvalidStart,        ///< outside the joint limits or not finite
  kFailed,              ///< a library or the heap gave up
};
constexpr std::size_t kPlanStatusCount = 11;
constexpr std::array<const char*, kPlanStatusCount> kPlanStatusNames{
    "none",    "success",   "start_in_collision",  "goal_unreachable", "goal_in_collision",
    "no_path", "cancelled", "dynamics_infeasible", "time_limit",       "invalid_start",
    "failed"};

constexpr std::size_t kMaxWaypoints = 64;

/** Answer of the planner. Waypoints are rest-to-rest: the arm stops at each (so that eq. 1 adds up over edges). */
struct PlanResult {
  std::uint32_t id{};
  PlanStatus status{PlanStatus::kNone};
  Arm arm{Arm::kGold};
  std::uint32_t waypoint_count{};
  std::array<JointArray, kMaxWaypoints> waypoints{};  ///< [rad, m] first is the start
  std::array<double, kMaxWaypoints> arrival{};        ///< [s] time of each from the start of the motion
  double cost{};                                      ///< eq. (1) of the paper
  double planning_time{};                             ///< [s] wall clock; in lockstep the fixed simulated delay
  double clearance{};       ///< [m] least distance to the scene, the other arm and itself in the roll-out of the path
  double tracking_error{};  ///< [m] greatest distance of the tip from its place on the path in that roll-out
  std::uint32_t samples{};  ///< used; includes those added after a failure; 0: OMPL does not say
  std::uint8_t robot_follows{};  ///< 1: the robot's own inverse kinematics takes the path's increments along the path
};
static_assert(std::is_trivially_copyable<PlanResult>::value, "travels in a ring");

/** Plans that may be asked for and not answered yet; the capacity of the rings to and from the planner. */
constexpr std::size_t kMaxPlansUnderWay = 4;

/** Why the execution of a plan ended. */
enum class ExecutionEnd : std::uint8_t {
  kNone,
  kFinished,    ///< at the goal and settled
  kReleased,    ///< the pedal went up
  kCancelled,   ///< by request: cancelled, disengaged, or another plan was wanted before the pedal came
  kEStop,       ///< the robot went to E-STOP, or the model broke down
  kTimeSlip,    ///< simulated time was lost
  kRobotLost,   ///< the robot's link, its homing or its readiness to follow was lost
  kOffPath,     ///< model or robot was farther from the path than allowed
  kNotSettled,  ///< the path was over, but model or robot did not come to rest at the goal in time
  kNoPedal,     ///< armed, but the pedal did not come in time
  kMoved,       ///< armed, but at pedal-down an arm had moved since the plan was requested
};
constexpr std::size_t kExecutionEndCount = 11;
constexpr std::array<const char*, kExecutionEndCount> kExecutionEndNames{
    "none",       "finished", "released",    "cancelled", "e_stop", "time_slip",
    "robot_lost", "off_path", "not_settled", "no_pedal",  "moved"};

/** How far a tool tip was from where the path put it at that instant. */
struct TrackingError {
  double mean{};     ///< [m] over the ticks from pedal-down to the end
  double largest{};  ///< [m] of those ticks
  double at_end{};   ///< [m] from where the path ends, in the last tick
};

/** How the execution of a plan went: one for each that was armed. */
struct ExecutionReport {
  std::uint32_t id{};    ///< of the request to execute
  std::uint32_t plan{};  ///< id of the plan
  Arm arm{Arm::kGold};
  std::uint8_t on_robot{};  ///< 1: the robot moved too
  ExecutionEnd end{ExecutionEnd::kNone};
  Tick started{-1};                ///< [1 ms] tick of the pedal-down; -1 the pedal never came
  Tick ended{-1};                  ///< [1 ms] first tick that no longer moved anything
  double path_time{};              ///< [s] that the path takes at full speed
  double progress{};               ///< [-] share of the path's time gone at the end, 0 to 1
  double planned_clearance{};      ///< [m] PlanResult::clearance
  TrackingError model{};           ///< of the nominal model
  TrackingError robot{};           ///< of the robot, as received; zero if it did not move
  double model_clearance{};        ///< [m] least distance of the model's arm to anything, at most 0.05; 0 it touched
  double robot_clearance{};        ///< [m] the same where the robot's joints put its arms; zero if it did not move
  std::uint32_t contact_ticks{};   ///< [1 ms] in which the model's arm touched something
  std::uint32_t contact_points{};  ///< most of them in one tick
};
static_assert(std::is_trivially_copyable<ExecutionReport>::value, "crosses threads word by word");

}  // namespace raven2_trainer
