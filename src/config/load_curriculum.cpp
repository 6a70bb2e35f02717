#include "raven2_trainer/config/load_curriculum.h"

#include <algorithm>
#include <filesystem>

#include "named_files.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

/** Names of files in the same folder; paths that lead elsewhere are refused. */
std::string readName(Section& section, const std::string& key) {
  const std::string name = section.text(key);
  const bool is_name = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (!is_name) throw ConfigException(section.where(key) + ": expected 1 to 64 of a-z, 0-9 and _");
  return name;
}

CurriculumStage readStage(Section& section) {
  CurriculumStage stage;
  stage.exercise = readName(section, "exercise");
  const std::string drill = readName(section, "drill");
  if (drill != "none") stage.drill = drill;
  stage.passes = section.integer("passes", 1, 100);
  stage.extra = section.integer("extra", 0, 1000);
  section.finish();
  return stage;
}

}  // namespace

Curriculum loadCurriculum(const std::string& path) {
  Section root = Section::fromFile(path);
  Curriculum curriculum;
  curriculum.name = fs::path(path).stem().string();
  curriculum.title = root.text("title");
  for (Section& stage : root.list("stages"))
    curriculum.stages.push_back(readStage(stage));
  if (curriculum.stages.empty()) throw ConfigException(root.where("stages") + " holds none");
  curriculum.deviations = root.number("deviations", 0.01, 5.0);
  root.finish();
  return curriculum;
}

Curriculum findCurriculum(const std::string& folder, const std::string& name) {
  return loadCurriculum(namedFile(folder, name, "curriculum", {}));
}

}  // namespace raven2_trainer::config
