#pragma once

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exercise.h"

// What scripted hands are told in an exercise's file: verbs and numbers that only they understand.

namespace raven2_trainer::config {

/** The optional keys `expert` and `clumsy`. */
void readScripts(Section& root, Exercise* exercise);

}  // namespace raven2_trainer::config
