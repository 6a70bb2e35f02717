#pragma once

#include <optional>
#include <string>

#include "raven2_trainer/training/band.h"

namespace raven2_trainer::config {

/**
 * One file of config/bands; its form is described in doc/scores.md.
 * @throw ConfigException with FILE:LINE for a missing or unknown key and a value that is out of its range.
 */
Band loadBand(const std::string& path);

/** The band of an exercise in a folder; nothing without one. @throw ConfigException as loadBand(). */
std::optional<Band> findBand(const std::string& folder, const std::string& exercise);

}  // namespace raven2_trainer::config
