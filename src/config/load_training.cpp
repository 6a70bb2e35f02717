#include "raven2_trainer/config/load_training.h"

#include <algorithm>
#include <filesystem>

#include "named_files.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_exercise.h"
#include "raven2_trainer/config/load_scene.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestTrainee = 32;  // a name in lists and reports, no more
constexpr const char* kOwnDrill = "own";     // the one that the exercise names

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
  const std::string file = namedFile(c->exercises, c->exercise_name, "exercise", {"none"});
  Section exercise = Section::fromFile(file);
  const std::string scene = namedFile(c->scenes, exercise.text("scene"), "scene", {}, exercise.where("scene"));
  c->files.insert(c->files.end(), {file, scene});
  c->roles = loadScene(scene);
  c->exercise = loadExercise(file, c->roles);
  c->scene_urdf = c->roles.urdf;
  c->urdf_places[c->roles.urdf] = c->roles.urdf_place;
  c->runtime.plan_at = -1.0;  // a path that is shown goes through everything, and what the jaws hold is let go
  const fs::path band = fs::path(c->bands) / (c->exercise_name + ".yaml");
  if (fs::exists(band)) c->files.push_back(band.string());  // what its scores are judged by
}

/** The exercise says when a drill comes and which response is right: without that it has no drill. */
void setDrill(TrainerConfig* c) {
  const std::string& own = c->exercise.drill.scenario;
  if (c->drill != "none" && own.empty()) {
    throw ConfigException("drill is \"" + c->drill + "\", but " + c->exercise.file +
                          " has no key drill, which says when it strikes and what is right then");
  }
  if (c->drill == kOwnDrill) c->drill = own;
  c->hazard = c->drill;
  checkHazard(*c);
}

}  // namespace

void loadTraining(const TrainingNames& names, TrainerConfig* config) {
  config->exercise_name = names.exercise;
  config->drill = names.drill;
  config->trainee = names.trainee;
  config->curriculum = names.curriculum;
  checkTrainee(config->trainee);
  if (config->curriculum != "none") {
    config->files.push_back(namedFile(config->curricula, config->curriculum, "curriculum", {"none"}));
  }
  if (config->exercise_name == "none") {
    if (config->drill == "none") return;
    throw ConfigException("drill is \"" + config->drill + "\", but there is no exercise that could run into it");
  }
  readExercise(config);
  setDrill(config);
}

}  // namespace raven2_trainer::config
