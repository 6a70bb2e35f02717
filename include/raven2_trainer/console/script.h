#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/console/clumsy.h"
#include "raven2_trainer/console/expert.h"
#include "raven2_trainer/core/exercise.h"

namespace raven2_trainer::console {

/** Actions of an exercise's expert, with the scene's names found. @throw ConfigException with FILE:LINE. */
std::vector<Verb> verbsOf(const Exercise& exercise, const SceneRoles& roles);

/** Differences of a clumsy surgeon of that exercise. `expect/...` is for tests of the score.
 *  @throw ConfigException with FILE:LINE, also for an unknown name. */
Clumsiness clumsinessOf(const Exercise& exercise, const SceneRoles& roles, const std::string& name);

}  // namespace raven2_trainer::console
