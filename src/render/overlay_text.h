#pragma once

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** [m] Distance of the model's and the robot's tip of an arm; NaN before the robot's first frame. */
double tipError(const Snapshot& snapshot, Arm arm) noexcept;

/** What the operator reads: session time, mode, run level, pedal, error of each arm, forces, the fault while it acts;
 *  that the real camera is silent, if its picture is the one asked for. */
Overlay describe(const Snapshot& snapshot, const HapticGains& haptics);

}  // namespace raven2_trainer::render
