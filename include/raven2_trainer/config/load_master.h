#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/console/master.h"

namespace raven2_trainer::config {

/** One file of config/masters. @throw ConfigException with FILE:LINE. */
MasterConfig loadMaster(const std::string& path);

/**
 * A master by name, or the path of a file ending in .yaml.
 * @param[in] folder the folder of the packaged ones, config/masters.
 * @throw ConfigException with FILE:LINE, or listing the known names.
 */
MasterConfig findMaster(const std::string& folder, const std::string& name);

}  // namespace raven2_trainer::config
