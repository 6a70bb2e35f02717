#pragma once

#include <cstdint>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/faults/fault_library.h"

namespace raven2_trainer::ros_bridge {

/** @param[in] id of the hazard; 0: none. @throw ConfigException if it may not be armed on this robot, with what it
 * would take; for FaultOrder::kArmAtOnce also if it would act on a robot that is missing. */
void refuseHazard(const faults::FaultLibrary& library, const RobotState& robot, std::uint32_t id, FaultOrder order);

}  // namespace raven2_trainer::ros_bridge
