#include "raven2_trainer/model/mesh_files.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

namespace raven2_trainer::model {

namespace {

namespace fs = std::filesystem;
}  // namespace

std::string modelFolder(const std::string& urdf) {
  const fs::path folder = fs::absolute(urdf).lexically_normal().parent_path();
  return (folder.filename() == "urdf" ? folder.parent_path() : folder).string();
}

std::string meshPath(const std::string& urdf, const std::string& name) {
  const bool is_ours = name.rfind(kPackage, 0) == 0;
  const fs::path folder = is_ours ? fs::path(modelFolder(urdf)) : fs::absolute(urdf).parent_path();
  return (folder / (is_ours ? name.substr(kPackage.size()) : name)).lexically_normal().string();
}

std::vector<std::string> meshFiles(const std::string& urdf) {
  std::ifstream in(urdf);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::regex attribute(R"re(filename\s*=\s*["']([^"']*)["'])re");
  std::vector<std::string> files;
  for (std::sregex_iterator match(text.begin(), text.end(), attribute), end; match != end; ++match) {
    const std::string path = meshPath(urdf, (*match)[1]);
    std::error_code error;
    const bool is_new = std::find(files.begin(), files.end(), path) == files.end();
    if (is_new && fs::is_regular_file(path, error)) files.push_back(path);
  }
  return files;
}

}  // namespace raven2_trainer::model
