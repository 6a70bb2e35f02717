#pragma once

#include "raven2_trainer/core/ticks.h"

// What a surgeon notices of a robot that leaves its model, and how soon anybody can answer (doc/scores.md, "Hazards").

namespace raven2_trainer {

constexpr double kFeltForce = 0.5;  ///< [N] on a hand; ours: what the force cue begins with (haptics.yaml), and a sixth
                                    ///< of an Omni's 3.3 N
constexpr double kSeenGap = 0.003;  ///< [m] between the tips of model and robot; ours: below it the cue is silent, too
constexpr Tick kNoticed = 100;      ///< [ms] that either has to last; ours: three pictures of the tools
constexpr Tick kQuickest =
    100;  ///< [ms] from a cue to the soonest answer: below it athletics calls a start a false one

}  // namespace raven2_trainer
