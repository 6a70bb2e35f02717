#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/training/curriculum.h"

namespace raven2_trainer::config {

/**
 * One file of config/curricula; its form is described in doc/scores.md.
 * @throw ConfigException with FILE:LINE for a missing or unknown key, a value out of its range and a name that no
 * exercise or scenario can have.
 */
Curriculum loadCurriculum(const std::string& path);

/** A curriculum by name. @throw ConfigException as above, or listing the known names. */
Curriculum findCurriculum(const std::string& folder, const std::string& name);

}  // namespace raven2_trainer::config
