#pragma once

#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/state.h"

// Results of planning and executing, in the numbers that clients of MoveIt know. Source: MoveItErrorCodes.msg of
// moveit_msgs for ROS 1 (https://docs.ros.org/en/api/moveit_msgs/html/msg/MoveItErrorCodes.html), not in Debian.

namespace raven2_trainer::ros_bridge {

/** The values of moveit_msgs/MoveItErrorCodes that we give. */
enum class ErrorCode : std::int32_t {
  kSuccess = 1,
  kFailure = 99999,
  kPlanningFailed = -1,
  kInvalidMotionPlan = -2,
  kInvalidatedByEnvironmentChange = -3,  ///< MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
  kControlFailed = -4,
  kTimedOut = -6,
  kPreempted = -7,
  kStartStateInCollision = -10,
  kGoalInCollision = -12,
  kInvalidGroupName = -15,
  kInvalidGoalConstraints = -16,
  kInvalidRobotState = -17,
  kRobotStateStale = -23,
  kCommunicationFailure = -25,
  kStartStateInvalid = -26,
  kAbort = -30,
  kNoIkSolution = -31,
};

/** No throw; kFailure for a value outside of the enumeration. */
ErrorCode errorCode(PlanStatus status) noexcept;
ErrorCode errorCode(PlanningAnswer answer) noexcept;
ErrorCode errorCode(ExecutionEnd end) noexcept;

constexpr std::int32_t number(ErrorCode code) noexcept {
  return static_cast<std::int32_t>(code);
}

}  // namespace raven2_trainer::ros_bridge
