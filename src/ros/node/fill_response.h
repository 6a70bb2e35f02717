#pragma once

#include <string>

#include "raven2_trainer/core/state.h"
#include "ros/raven/error_codes.h"

// The physics loop's answers in the responses of services.

namespace raven2_trainer::ros_bridge {

/** "no answer" for none. */
inline std::string words(PlanningAnswer answer) {
  return answer != PlanningAnswer::kNone ? kPlanningAnswerNames[static_cast<std::size_t>(answer)] : "no answer";
}

/** success, status and error_code of any response. */
template <typename Response>
void fillResponse(ErrorCode code, const std::string& status, Response* response) {
  response->success = code == ErrorCode::kSuccess;
  response->status = status;
  response->error_code = number(code);
}

template <typename Response>
void fillResponse(PlanningAnswer answer, Response* response) {
  fillResponse(errorCode(answer), words(answer), response);
}

}  // namespace raven2_trainer::ros_bridge
