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

std::string neighbour(const std::string& folder, const std::string& file, const std::string& place) {
  const fs::path own = (fs::absolute(folder) / file).lexically_normal();
  std::error_code error;
  if (fs::exists(own, error) || file.rfind("../", 0) != 0) return own.string();
  for (const fs::path& share : candidates()) {
    const fs::path packaged = (fs::absolute(share) / place / file).lexically_normal();
    if (fs::exists(packaged, error)) return packaged.string();
  }
  return own.string();
}

}  // namespace raven2_trainer::config
