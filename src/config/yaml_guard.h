#pragma once

#include <string>

namespace raven2_trainer::config {

/**
 * Reads a YAML text for its shape alone, keeping nothing, before the tree of it is built: a few lines of YAML can ask
 * for gigabytes. Refused: nesting beyond 64, more than 20,000 values, anchors and aliases, tags, a second document.
 * @throw ConfigException FILE:LINE:; YAML::Exception for what is no YAML.
 */
void checkYaml(const std::string& text, const std::string& file);

}  // namespace raven2_trainer::config
