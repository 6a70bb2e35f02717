#pragma once

#include <string>
#include <vector>

namespace raven2_trainer::apps {

/** File of one of our scripts: next to the program (installed), or in scripts/ of the source tree.
 *  @throw ConfigException if it is in neither. */
std::string scriptPath(const std::string& name);

/** Runs one of our Python scripts and waits for it. @return its exit status; 1 if a signal ended it.
 *  @throw ConfigException if it cannot be found or started. */
int runScript(const std::string& name, const std::vector<std::string>& arguments);

}  // namespace raven2_trainer::apps
