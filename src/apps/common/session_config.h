#pragma once

#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::apps {

/**
 * The configuration for viewing a recorded session: the copy in the session, with its exercise and scene, and `render` of the
 * packaged one. If the copy is missing, altered or of an older format, warns on stderr and uses the packaged configuration.
 * @param[in] root configuration file to use instead of both, or empty.
 * @throw ConfigException, SessionException.
 */
TrainerConfig viewingConfig(const session::SessionPaths& paths, const std::string& root);

}  // namespace raven2_trainer::apps
