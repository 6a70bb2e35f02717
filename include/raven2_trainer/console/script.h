#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/console/clumsy.h"
#include "raven2_trainer/console/expert.h"
#include "raven2_trainer/core/exercise.h"

namespace raven2_trainer::console {

/** What an exercise's expert does, its names found in the scene. @throw ConfigException with FILE:LINE. */
std::vector<Verb> verbsOf(const Exercise& exercise, const SceneRoles& roles);

/** How a clumsy hand of that exercise differs. What is expected of it (`expect/...`) is for whoever checks the score.
 *  @throw ConfigException with FILE:LINE, also if there is no such hand. */
Clumsiness clumsinessOf(const Exercise& exercise, const SceneRoles& roles, const std::string& name);

}  // namespace raven2_trainer::console
