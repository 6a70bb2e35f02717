#pragma once

#include "raven2_trainer/core/ticks.h"

// What a surgeon notices of a robot that leaves its model, and how soon anybody can answer (doc/scores.md, "Hazards").

namespace raven2_trainer {

/** [N] on a hand. Ours: what the force cue begins with (config/haptics.yaml), a sixth of an Omni's 3.3 N. */
constexpr double kFeltForce = 0.5;

/** [m] between the tips of model and robot. Ours: the tolerance below which the force cue is silent. */
constexpr double kSeenGap = 0.003;

/** [ms] that either has to last. Ours: kSeenPictures at 30 Hz. */
constexpr Tick kNoticed = 100;
constexpr int kSeenPictures = 3;

/** [ms] from a cue to the soonest answer. Athletics calls what is sooner a false start. */
constexpr Tick kQuickest = 100;

}  // namespace raven2_trainer
