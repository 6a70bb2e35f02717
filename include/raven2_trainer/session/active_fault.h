#pragma once

#include <cstdint>

#include "raven2_trainer/core/state.h"

namespace raven2_trainer {

/** Fault::id of what acts, 0 none. The robot's word counts; what acts in the daemon alone, only the model tells. */
inline std::uint32_t activeFault(const ModelState& model, const RobotState& robot) noexcept {
  return robot.active_fault != 0 ? robot.active_fault : model.faults.active;
}

}  // namespace raven2_trainer
