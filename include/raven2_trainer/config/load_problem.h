#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/planning/plan_problem.h"

namespace raven2_trainer::config {

/**
 * One file of config/problems; its form is described in doc/planning.md.
 * @param[in] geometry whose limits the joints are held to.
 * @throw ConfigException with FILE:LINE for a missing or unknown key and a joint or place out of its range.
 */
PlanProblem loadProblem(const std::string& path, const ArmGeometry& geometry);

/**
 * A problem by name, or the path of a file ending in .yaml.
 * @param[in] folder the folder of the problems, config/problems.
 * @throw ConfigException with FILE:LINE, or listing the known names.
 */
PlanProblem findProblem(const std::string& folder, const std::string& name, const ArmGeometry& geometry);

}  // namespace raven2_trainer::config
