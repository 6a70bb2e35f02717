#include "raven2_trainer/config/overrides.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

constexpr std::array kParts{"arms", "model",  "haptics", "network",       "runtime",   "planner", "execution",
                            "crtk", "render", "console", "virtual_raven", "injection", "detector"};
constexpr std::array kFolders{"faults",    "impairments", "exercises",  "scenes",
                              "curricula", "bands",       "robot_urdf", "scene_urdf"};
// Paths; whom the daemon hears and believes; whether hazards may be armed, on a robot at that.
constexpr std::array kFilesAlone{"network/bind_address",
                                 "network/master_address",
                                 "network/auth",
                                 "network/ingest",
                                 "network/key_file",
                                 "network/stream",
                                 "network/allow_plaintext_remote",
                                 "runtime/flight_recorder",
                                 "runtime/enable_remote_control",
                                 "injection/enable",
                                 "injection/real_robot",
                                 "virtual_raven/plant"};

template <std::size_t N>
bool holds(const std::array<const char*, N>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/** Of a file: "haptics" of "haptics/tolerance"; empty for a key of the root file. */
std::string partOf(const std::string& key) {
  const std::size_t slash = key.find('/');
  return slash == std::string::npos ? "" : key.substr(0, slash);
}

}  // namespace

void checkOverrides(const Overrides& overrides) {
  for (const Override& each : overrides) {
    if (holds(kParts, each.key) || holds(kFolders, each.key))
      throw ConfigException(each.source + ": " + each.key + " names what is read; a file given with --config may");
    if (holds(kFilesAlone, each.key))
      throw ConfigException(each.source + ": " + each.key + " can be set in the configuration's files alone");
  }
}

Overrides overridesOf(const Overrides& overrides, const std::string& part) {
  Overrides own;
  for (const Override& each : overrides) {
    if (partOf(each.key) == part) own.push_back({each.key.substr(part.size() + 1), each.value, each.source});
  }
  return own;
}

Overrides overridesOfRoot(const Overrides& overrides) {
  Overrides own;
  std::copy_if(overrides.begin(), overrides.end(), std::back_inserter(own),
               [](const Override& each) { return !holds(kParts, partOf(each.key)); });
  return own;
}

}  // namespace raven2_trainer::config
