#include "raven2_trainer/config/load_training.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_exercise.h"
#include "raven2_trainer/config/load_scene.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestTrainee = 32;  // a name in lists and reports, no more

std::vector<std::string> namesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/** The file of that name; a name is one of the folder's, so none leads out of it. */
std::string fileOf(const std::string& folder, const std::string& name, const char* what) {
  const std::vector<std::string> names = namesIn(folder);
  if (std::find(names.begin(), names.end(), name) != names.end()) return (fs::path(folder) / (name + ".yaml")).string();
  std::string known = "none";
  for (const std::string& each : names)
    known += ", " + each;
  throw ConfigException(std::string("no ") + what + " is called \"" + name + "\"; known: " + known);
}

void checkTrainee(const std::string& id) {
  const bool is_good = std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  if (is_good && id.size() <= kLongestTrainee) return;
  throw ConfigException("trainee is \"" + id + "\", expected at most " + std::to_string(kLongestTrainee) +
                        " of a-z, 0-9, _ and -");
}

/** Scene first: the exercise speaks of its parts by name. */
void readExercise(TrainerConfig* c) {
  const std::string file = fileOf(c->exercises, c->exercise_name, "exercise");
  const std::string scene = fileOf(c->scenes, Section::fromFile(file).text("scene"), "scene");
  c->files.insert(c->files.end(), {file, scene});
  c->roles = loadScene(scene);
  c->exercise = loadExercise(file, c->roles);
  c->scene_urdf = c->roles.urdf;
  c->runtime.plan_at = -1.0;  // a path that is shown goes through everything, and what the jaws hold is let go
  const fs::path band = fs::path(c->bands) / (c->exercise_name + ".yaml");
  if (fs::exists(band)) c->files.push_back(band.string());  // what its scores are judged by
}

}  // namespace

void loadTraining(const TrainingNames& names, TrainerConfig* config) {
  config->exercise_name = names.exercise;
  config->drill = names.drill;
  config->trainee = names.trainee;
  config->curriculum = names.curriculum;
  checkTrainee(config->trainee);
  if (config->curriculum != "none") {
    config->files.push_back(fileOf(config->curricula, config->curriculum, "curriculum"));
  }
  if (config->exercise_name == "none") {
    if (config->drill == "none") return;
    throw ConfigException("drill is \"" + config->drill + "\", but there is no exercise that could run into it");
  }
  readExercise(config);
  config->hazard = config->drill;
  checkHazard(*config);
}

}  // namespace raven2_trainer::config
