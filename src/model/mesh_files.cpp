#include "raven2_trainer/model/mesh_files.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

namespace raven2_trainer::model {

namespace {

namespace fs = std::filesystem;
const std::string kPackage = "package://raven2_trainer/";
const std::string kFile = "file://";

}  // namespace

std::string meshPath(const std::string& urdf, const std::string& name) {
  const fs::path folder = fs::absolute(urdf).lexically_normal().parent_path();
  if (name.rfind(kPackage, 0) == 0) return (folder.parent_path() / name.substr(kPackage.size())).string();
  if (name.rfind(kFile, 0) == 0) return name.substr(kFile.size());
  return (folder / name).lexically_normal().string();
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
