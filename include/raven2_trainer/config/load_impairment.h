#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/impair/impairment.h"

namespace raven2_trainer::config {

/** One file of config/impairments. @throw ConfigException with FILE:LINE. */
Impairment loadImpairment(const std::string& path);

/**
 * A preset by name, or the path of a file ending in .yaml; "none" is a perfect link.
 * @param[in] folder the folder of the presets, config/impairments.
 * @throw ConfigException with FILE:LINE, or listing the known names.
 */
Impairment findImpairment(const std::string& folder, const std::string& name);

/** Folder of the presets that a root file like config/trainer.yaml names; the packaged one without a root file, or if
 *  there is no such folder. @throw ConfigException for a root file that cannot be read. */
std::string impairmentFolder(const std::string& root);

/** Names of the presets in a folder, sorted. */
std::vector<std::string> impairmentNames(const std::string& folder);

}  // namespace raven2_trainer::config
