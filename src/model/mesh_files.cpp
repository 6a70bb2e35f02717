#include "raven2_trainer/model/mesh_files.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

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

namespace {

/** Values of all attributes `filename`, also in comments. std::regex would recurse for each character of a value. */
std::vector<std::string> fileNames(const std::string& text) {
  const std::string attribute = "filename", blank = " \t\r\n";
  constexpr auto kNone = std::string::npos;
  std::vector<std::string> names;
  for (std::size_t at = text.find(attribute); at != kNone; at = text.find(attribute, at + 1)) {
    const std::size_t equals = text.find_first_not_of(blank, at + attribute.size());
    if (equals == kNone || text[equals] != '=') continue;
    const std::size_t quote = text.find_first_not_of(blank, equals + 1);
    if (quote == kNone || (text[quote] != '"' && text[quote] != '\'')) continue;
    const std::size_t end = text.find_first_of("\"'", quote + 1);
    if (end == kNone) break;
    names.push_back(text.substr(quote + 1, end - quote - 1));
  }
  return names;
}

}  // namespace

std::vector<std::string> meshFiles(const std::string& urdf) {
  std::ifstream in(urdf);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::vector<std::string> files;
  for (const std::string& name : fileNames(text)) {
    const std::string path = meshPath(urdf, name);
    std::error_code error;
    const bool is_new = std::find(files.begin(), files.end(), path) == files.end();
    if (is_new && fs::is_regular_file(path, error)) files.push_back(path);
  }
  return files;
}

}  // namespace raven2_trainer::model
