#pragma once

#include <string>

namespace raven2_trainer::apps {

/** The packaged configuration, config/trainer.yaml. @throw ConfigException. */
std::string defaultConfigPath();

/** Version of this build. */
std::string version();

}  // namespace raven2_trainer::apps
