#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// What travels through rings: each element counts, none may be lost or seen twice.

namespace raven2_trainer {

/** One accepted ITP packet of the masters. Increments are already scaled by the master (ITP has no scale). */
struct MasterCommand {
  std::uint32_t sequence{};
  std::uint8_t pedal{};                               ///< surgeon_mode != 0
  PerArm<Vec3> dp_I{};                                ///< [m] [@frame I] position increment
  PerArm<Quat> dq_I{{kIdentityQuat, kIdentityQuat}};  ///< [@frame I] incremental orientation
  PerArm<double> dgrasp{};                            ///< [rad] grasp increment, positive closes
};

/** What the relay sends the robot for one tick: the increments that the model applied. */
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
enum class RequestKind : std::uint8_t { kNone, kEngage, kDisengage, kPlan, kCancelPlan, kSetCollisions };
constexpr std::size_t kRequestKindCount = 6;
constexpr std::array<const char*, kRequestKindCount> kRequestKindNames{"none", "engage",      "disengage",
                                                                       "plan", "cancel_plan", "set_collisions"};

struct Request {
  RequestKind kind{RequestKind::kNone};
  Arm arm{Arm::kGold};
  std::uint8_t has_goal{};  ///< 0: the goal of planner.yaml
  std::uint8_t enabled{};   ///< kSetCollisions: 1 the arm meets scene and other arm, 0 it passes through
  Vec3 goal_W{};            ///< [m] [@frame W] tip position to reach, orientation free
  std::uint32_t id{};       ///< chosen by the sender, comes back in PlanResult::id
};

/** Orders to the fault director. */
struct FaultRequest {
  std::uint8_t start{};      ///< 1 arm the scenario, 0 clear it
  std::uint32_t fault_id{};  ///< index in the scenario library + 1; 0 with start = 0 clears all
};

/** Problem handed to the planner thread. */
struct PlanRequest {
  std::uint32_t id{};
  Tick requested_tick{};
  Arm arm{Arm::kGold};
  JointArray start{};  ///< [rad, m] where the arm stands
  JointArray other{};  ///< [rad, m] where the other arm stands
  std::uint8_t has_goal{};
  Vec3 goal_W{};  ///< [m]
};

enum class PlanStatus : std::uint8_t {
  kNone,
  kSuccess,
  kStartInCollision,
  kGoalUnreachable,
  kGoalInCollision,
  kNoPath,
  kCancelled,
};
constexpr std::size_t kPlanStatusCount = 7;
constexpr std::array<const char*, kPlanStatusCount> kPlanStatusNames{
    "none", "success", "start_in_collision", "goal_unreachable", "goal_in_collision", "no_path", "cancelled"};

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
  std::uint32_t samples{};
};
static_assert(std::is_trivially_copyable<PlanResult>::value, "travels in a ring");

}  // namespace raven2_trainer
