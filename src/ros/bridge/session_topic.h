#pragma once

#include <ros/time.h>

#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/SessionConfiguration.h"
#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer::ros_bridge {

/** Path and hash (session::readHash) of each file. */
using FileHashes = std::vector<std::pair<std::string, std::string>>;

/** Of the configuration's files, root first, and the URDFs. To be taken as the program begins: a file that is changed
 * later is not what runs. @throw SessionException if one cannot be read. */
FileHashes hashConfiguration(const TrainerConfig& config);

/** @param[in] directory of the session. */
SessionConfiguration sessionConfiguration(const TrainerConfig& config,
                                          const std::string& directory,
                                          const FileHashes& hashes,
                                          const ros::Time& stamp);

}  // namespace raven2_trainer::ros_bridge
