#pragma once

#include <cstdint>

#include "raven2_trainer/core/state.h"

namespace raven2_trainer {

/** Fault::id of the active fault; 0 if no fault is active. The robot's report has priority; faults that run in the
 * daemon are only in the model's state. */
inline std::uint32_t activeFault(const ModelState& model, const RobotState& robot) noexcept {
  return robot.active_fault != 0 ? robot.active_fault : model.faults.active;
}

}  // namespace raven2_trainer
