#pragma once

#include <string>

#include "raven2_trainer/wire/stream_profile.h"

namespace raven2_trainer::config {

/** One file of config/streams. @throw ConfigException with FILE:LINE. */
StreamProfile loadStream(const std::string& path);

/** The file of a profile by its name; empty for "none". @param[in] folder config/streams.
 *  @throw ConfigException naming all that are known. */
std::string streamFile(const std::string& folder, const std::string& name);

}  // namespace raven2_trainer::config
