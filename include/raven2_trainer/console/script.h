#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/console/clumsy.h"
#include "raven2_trainer/console/expert.h"
#include "raven2_trainer/core/exercise.h"

namespace raven2_trainer::console {

/** Actions of an exercise's expert, with scene names resolved. @throw ConfigException with FILE:LINE. */
std::vector<Verb> verbsOf(const Exercise& exercise, const SceneRoles& roles);

/** How a clumsy surgeon of that exercise differs. Keys `expect/...` (for tests) are ignored.
 *  @throw ConfigException with FILE:LINE, also for an unknown name. */
Clumsiness clumsinessOf(const Exercise& exercise, const SceneRoles& roles, const std::string& name);

}  // namespace raven2_trainer::console
