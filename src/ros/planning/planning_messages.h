#pragma once

#include <nav_msgs/Path.h>
#include <ros/time.h>
#include <trajectory_msgs/JointTrajectory.h>

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/MoveArmResult.h"
#include "raven2_trainer/PlanExecution.h"
#include "raven2_trainer/PlanPath.h"
#include "raven2_trainer/PlanningProgress.h"
#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/loop/plan_counts.h"
#include "ros/planning/move_arm_task.h"
#include "ros/raven/error_codes.h"

// Plans, their progress and their execution as messages. Names and coordinates of joints as in ros/messages.h.

namespace raven2_trainer::ros_bridge {

/** What a client may ask a plan for, however it is sent: fields as in PlanPath.srv. */
struct WantedPlan {
  std::string arm;
  bool default_goal{};
  Vec3 goal_W{};               ///< [m]
  std::vector<double> joints;  ///< [rad, m] URDF coordinates; empty: the tip counts
};

template <typename Message>
WantedPlan wantedPlan(const Message& message) {
  return {message.arm, message.default_goal != 0, {message.goal[0], message.goal[1], message.goal[2]}, message.joints};
}

/** A request, or the reason why there is no request. */
struct ReadRequest {
  ErrorCode code{ErrorCode::kFailure};
  std::string status;  ///< why not, with what is wanted
  Request request;     ///< valid if code is kSuccess

  bool isGood() const { return code == ErrorCode::kSuccess; }
};

/** @param[in] d4 [m] ArmGeometry::d4. Refuses unknown arms, goals that are not finite and joints without an arm. */
ReadRequest planRequest(const WantedPlan& wanted, double d4);

/** "gold" or "green". @return false, `*arm` unchanged, for anything else. */
bool readArm(const std::string& text, Arm* arm);

/**
 * Waypoints with the times of their arrival. The arm rests at each: with velocity and acceleration given as zero there,
 * a player that fits quintics (joint_trajectory_controller) moves as we do.
 */
trajectory_msgs::JointTrajectory trajectory(const PlanResult& plan, double d4);

/** Poses of the tool tip along a plan in frame world, 20 a segment. @param[in] X_WB the arm's base. */
nav_msgs::Path tipPath(const PlanResult& plan, const ArmGeometry& geometry, const Pose& X_WB, const ros::Time& stamp);

/** Of answers that came together, oldest first, the newest that is a path; null without one. A failed answer leaves the
 * path before it
 * unchanged. */
const PlanResult* newestPath(const std::vector<PlanResult>& answers) noexcept;

/** Time since planning has its status, by the model's clock, which stops when the daemon does. One thread. */
class StatusClock {
 public:
  /** A look at the newest state. @return true if status or plan are others than at the look before. */
  bool look(const ModelState& model);
  /** [s] from the first look at this status to the newest. */
  double elapsed() const { return static_cast<double>(now_ - since_) * kTickSeconds; }

 private:
  bool has_looked_{false};
  PlanningStatus status_{PlanningStatus::kIdle};
  std::uint32_t plan_{0};
  Tick since_{0}, now_{0};
};

/** @param[in] elapsed [s] since the status was this one. */
PlanningProgress planningProgress(const PlanningState& state,
                                  const PlanCounts& counts,
                                  double elapsed,
                                  const ros::Time& stamp);

PlanExecution planExecution(const ExecutionReport& report, const ros::Time& stamp);

MoveArmResult moveArmResult(const MoveArmTask::Outcome& outcome, const ros::Time& stamp);

/** [m] Distance of the tips of model and robot from where the model's arm is wanted in this tick. */
struct TipErrors {
  double model{};
  double robot{};  ///< zero if the robot does not move
};
TipErrors tipErrors(const ModelState& model, const RobotState& robot, const ArmGeometry& geometry);

}  // namespace raven2_trainer::ros_bridge
