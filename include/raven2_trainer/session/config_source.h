#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace raven2_trainer::session {

/** Files of a session's configuration. The configuration must outlive it. */
struct ConfigSource {
  const std::vector<std::string>& files;
  const std::map<std::string, std::string>& overridden;  ///< by path: text of each file with overridden values
  const std::string& robot_urdf;
  const std::string& scene_urdf;
  const std::string& hazard;
  const std::uint64_t seed;
};

}  // namespace raven2_trainer::session
