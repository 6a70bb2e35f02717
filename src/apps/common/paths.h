#pragma once

#include <string>

namespace raven2_trainer::apps {

/**
 * Folder with config/, urdf/ and meshes/: $RAVEN2_TRAINER_SHARE if set; else share/raven2_trainer beside the program's
 * lib folder (installed); else the source tree it was built from (devel space).
 * @throw ConfigException if none of them has a config/trainer.yaml.
 */
std::string shareFolder();

/** The packaged configuration, config/trainer.yaml. @throw ConfigException. */
std::string defaultConfigPath();

/** Version of this build. */
std::string version();

}  // namespace raven2_trainer::apps
