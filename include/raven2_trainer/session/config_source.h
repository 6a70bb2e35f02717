#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace raven2_trainer::session {

/** What a session was configured by. Refers to the configuration. */
struct ConfigSource {
  const std::vector<std::string>& files;
  const std::map<std::string, std::string>& overridden;  ///< those that were not read as they stand: what was read
  const std::string& robot_urdf;
  const std::string& scene_urdf;
  const std::string& hazard;
  const std::uint64_t seed;
};

}  // namespace raven2_trainer::session
