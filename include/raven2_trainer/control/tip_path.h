#pragma once

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/guide_path.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::control {

/**
 * Way of the tool tip along a plan: straight lines between its waypoints in joint space, each cut into equally many
 * pieces, as many as fit. Both ends are the plan's. Not for the 1 kHz loops: up to 256 forward kinematics.
 * @return without points if the plan did not succeed or its waypoints cannot be counted.
 */
GuidePath tipPath(const ArmGeometry& geometry, const PlanResult& plan) noexcept;

}  // namespace raven2_trainer::control
