#pragma once

#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::apps {

/**
 * What a recorded session is looked at with: the configuration that it keeps a copy of, exercise and scene of its own
 * among it; how pictures are made (`render`) is the packaged one's. A session whose copy is missing, altered, or of an
 * older format is looked at with the packaged configuration, which is said on stderr.
 * @param[in] root file to be used instead of both, or empty.
 * @throw ConfigException, SessionException.
 */
TrainerConfig viewingConfig(const session::SessionPaths& paths, const std::string& root);

}  // namespace raven2_trainer::apps
