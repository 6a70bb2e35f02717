#pragma once

#include <string>
#include <vector>

namespace raven2_trainer::config {

/** A value in place of one in a file of the configuration. */
struct Override {
  std::string key;     ///< "haptics/tolerance": the root file's name for the file, then the keys in it; "seed": its own
  std::string value;   ///< YAML, as in the file
  std::string source;  ///< who says so, for messages: "ROS parameter /raven2_simulator/haptics/tolerance"
};

using Overrides = std::vector<Override>;

/**
 * Some keys are the files' alone, since every program that reaches a ROS master can set parameters. They decide which
 * files are read and written, whose packets are accepted, and what may be injected.
 * @throw ConfigException naming the first such key.
 */
void checkOverrides(const Overrides& overrides);

/** Those that go to the file that the root file calls `part`, their keys without that. */
Overrides overridesOf(const Overrides& overrides, const std::string& part);

/** Those of the root file itself, and those that name no other: reading it refuses them as unknown keys. */
Overrides overridesOfRoot(const Overrides& overrides);

}  // namespace raven2_trainer::config
