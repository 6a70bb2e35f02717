#include "named_files.h"

#include <algorithm>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/nearest_name.h"

namespace raven2_trainer::config {

namespace fs = std::filesystem;

std::vector<std::string> namesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string namedFile(const std::string& folder,
                      const std::string& name,
                      const char* what,
                      const std::vector<std::string>& also,
                      const std::string& place) {
  std::vector<std::string> names = namesIn(folder);
  if (std::find(names.begin(), names.end(), name) != names.end()) return (fs::path(folder) / (name + ".yaml")).string();
  names.insert(names.begin(), also.begin(), also.end());
  throw ConfigException((place.empty() ? "" : place + ": ") + unknownName(what, name, names));
}

}  // namespace raven2_trainer::config
