#include "ros/raven/error_codes.h"

#include <array>

namespace raven2_trainer::ros_bridge {
namespace {

template <typename Enum, std::size_t Count>
ErrorCode look(const std::array<ErrorCode, Count>& codes, Enum value) noexcept {
  const auto i = static_cast<std::size_t>(value);
  return i < Count ? codes[i] : ErrorCode::kFailure;
}

// By value of the enumeration, in its order.
constexpr std::array<ErrorCode, kPlanStatusCount> kOfPlans{
    ErrorCode::kFailure,                // none
    ErrorCode::kSuccess,                // success
    ErrorCode::kStartStateInCollision,  // start_in_collision
    ErrorCode::kNoIkSolution,           // goal_unreachable
    ErrorCode::kGoalInCollision,        // goal_in_collision
    ErrorCode::kPlanningFailed,         // no_path
    ErrorCode::kPreempted,              // cancelled
    ErrorCode::kInvalidMotionPlan,      // dynamics_infeasible
    ErrorCode::kTimedOut,               // time_limit
    ErrorCode::kStartStateInvalid,      // invalid_start
    ErrorCode::kFailure,                // failed
};

constexpr std::array<ErrorCode, kPlanningAnswerCount> kOfAnswers{
    ErrorCode::kCommunicationFailure,            // none: the loop did not answer
    ErrorCode::kSuccess,                         // accepted
    ErrorCode::kInvalidRobotState,               // not_now
    ErrorCode::kInvalidMotionPlan,               // no_plan
    ErrorCode::kInvalidatedByEnvironmentChange,  // moved
    ErrorCode::kRobotStateStale,                 // no_robot
    ErrorCode::kInvalidMotionPlan,               // robot_cannot_follow
};

constexpr std::array<ErrorCode, kExecutionEndCount> kOfExecutions{
    ErrorCode::kFailure,                         // none
    ErrorCode::kSuccess,                         // finished
    ErrorCode::kPreempted,                       // released
    ErrorCode::kPreempted,                       // cancelled
    ErrorCode::kAbort,                           // e_stop
    ErrorCode::kControlFailed,                   // time_slip
    ErrorCode::kRobotStateStale,                 // robot_lost
    ErrorCode::kControlFailed,                   // off_path
    ErrorCode::kControlFailed,                   // not_settled
    ErrorCode::kTimedOut,                        // no_pedal
    ErrorCode::kInvalidatedByEnvironmentChange,  // moved
};

}  // namespace

ErrorCode errorCode(PlanStatus status) noexcept {
  return look(kOfPlans, status);
}

ErrorCode errorCode(PlanningAnswer answer) noexcept {
  return look(kOfAnswers, answer);
}

ErrorCode errorCode(ExecutionEnd end) noexcept {
  return look(kOfExecutions, end);
}

}  // namespace raven2_trainer::ros_bridge
