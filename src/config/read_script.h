#pragma once

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exercise.h"

// The simulated surgeon's script in an exercise's file: its verbs and numbers.

namespace raven2_trainer::config {

/** The optional keys `expert` and `clumsy`. */
void readScripts(Section& root, Exercise* exercise);

}  // namespace raven2_trainer::config
