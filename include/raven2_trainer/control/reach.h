#pragma once

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::control {

/** Whether an arm of the model is at the edge of its workspace: the hand that moves it asks for a pose beyond the
 * joints' limits, out of its reach, or too near to the remote centre. A topic publishes it, and a video plays a tone.
 * Real-time safe. */
constexpr bool isAtEdge(const ModelState& model, Arm arm) noexcept {
  const auto status = static_cast<kinematics::IkStatus>(model.arms[static_cast<std::size_t>(arm)].ik_status);
  return traitsOf(model.mode).hands && status != kinematics::IkStatus::kOk &&
         status != kinematics::IkStatus::kSingularWrist;
}

}  // namespace raven2_trainer::control
