#include "raven2_trainer/config/share_folder.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> candidates() {
  std::vector<fs::path> folders;
  const char* folder = std::getenv("RAVEN2_TRAINER_SHARE");
  if (folder != nullptr && *folder != '\0') folders.emplace_back(folder);
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

Neighbour neighbour(const std::string& folder, const std::string& file, const std::string& packaged) {
  const std::string own = (fs::absolute(folder) / file).lexically_normal().string();
  std::error_code error;
  if (fs::exists(own, error) || file.rfind("../", 0) != 0) return {own, own};
  for (const fs::path& share : candidates()) {
    const fs::path found = (fs::absolute(share) / packaged / file).lexically_normal();
    if (fs::exists(found, error)) return {found.string(), own};
  }
  return {own, own};
}

}  // namespace raven2_trainer::config
