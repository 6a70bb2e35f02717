#include "ros/bridge/session_topic.h"

#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer::ros_bridge {

FileHashes hashConfiguration(const TrainerConfig& config) {
  std::vector<std::string> files = config.files;
  files.insert(files.end(), {config.robot_urdf, config.scene_urdf});
  FileHashes hashes;
  for (const std::string& file : files)
    hashes.emplace_back(file, session::readHash(config, file));
  return hashes;
}

SessionConfiguration sessionConfiguration(const TrainerConfig& config,
                                          const std::string& directory,
                                          const FileHashes& hashes,
                                          const ros::Time& stamp) {
  SessionConfiguration message;
  message.header.stamp = stamp;
  message.directory = directory;
  message.seed = config.seed;
  message.hazard = config.hazard;
  message.exercise = config.exercise_name;
  message.drill = config.drill;
  for (const auto& [path, hash] : hashes) {
    ConfigurationHash file;
    file.path = path;
    file.fnv1a = hash;
    message.files.push_back(file);
  }
  return message;
}

}  // namespace raven2_trainer::ros_bridge
