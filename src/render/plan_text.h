#pragma once

#include <string>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** [m] How far the tip of the arm that executes a plan is from where the path puts it, by the desired joints of that
 * tick; the farther of model and robot if both move. */
double pathError(const ArmGeometry& geometry, const Snapshot& snapshot) noexcept;

/**
 * The operator's text about planning and executing: present activity, effect of the pedal, result of the newest
 * plan. Empty before the first plan.
 * @param[in] path_error [m] of pathError().
 */
std::string planLine(const Snapshot& snapshot, double path_error);

}  // namespace raven2_trainer::render
