#pragma once

#include "raven2_trainer/render/renderer.h"

namespace raven2_trainer::render {

/** [m] Distance of the model's and the robot's tip of an arm; NaN before the robot's first frame. */
double tipError(const Snapshot& snapshot, Arm arm) noexcept;

/** The operator's text, as far as SceneOptions::overlays selects it: session time, mode, run level, pedal, error
 * of each arm; forces; age of the robot's state; the exercise; the fault while it acts, and what it does to the
 * trainee's picture. In any case that the real camera is silent, if its picture is the one asked for. Not the plan, not
 * limits. */
Overlay describe(const Snapshot& snapshot, const SceneOptions& options);

}  // namespace raven2_trainer::render
