#pragma once

#include <string>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** [m] How far the tip of the arm that executes a plan is from where the path puts it, by the desired joints of that
 * tick; the farther of model and robot if both move. */
double pathError(const ArmGeometry& geometry, const Snapshot& snapshot) noexcept;

/**
 * What the operator reads of planning and executing: what is going on, what the pedal would do, how the newest plan
 * ended. Empty where nobody has asked for a plan.
 * @param[in] path_error [m] of pathError().
 */
std::string planLine(const Snapshot& snapshot, double path_error);

}  // namespace raven2_trainer::render
