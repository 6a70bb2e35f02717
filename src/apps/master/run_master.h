#pragma once

#include <string>

#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer::apps {

/** A console with haptic devices. */
struct MasterOptions {
  std::string master;    ///< name in config/masters, or a file
  double scale{0.0};     ///< instead of the file's; 0: the file's
  double duration{0.0};  ///< [s] until it ends; 0: at a signal
};

/**
 * master_console --master: sends ITP from the devices and forces to them, as a ROS node. Prints troubles of devices on
 * stderr. @return the exit code. @throw ConfigException, NetworkException.
 */
int runMaster(TrainerConfig config, const MasterOptions& options, int argc, char** argv);

}  // namespace raven2_trainer::apps
