#include "apps/common/paths.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> candidates() {
  std::vector<fs::path> folders;
  if (const char* folder = std::getenv("RAVEN2_TRAINER_SHARE")) folders.emplace_back(folder);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(program.parent_path().parent_path().parent_path() / "share" / "raven2_trainer");
  folders.emplace_back(RAVEN2_TRAINER_SOURCE_DIR);
  return folders;
}

}  // namespace

std::string shareFolder() {
  std::string tried;
  for (const fs::path& folder : candidates()) {
    if (fs::exists(folder / "config" / "trainer.yaml")) return folder.string();
    tried += " " + folder.string();
  }
  throw ConfigException("no config/trainer.yaml in any of:" + tried);
}

std::string defaultConfigPath() {
  return shareFolder() + "/config/trainer.yaml";
}

std::string version() {
  return RAVEN2_TRAINER_VERSION;
}

}  // namespace raven2_trainer::apps
