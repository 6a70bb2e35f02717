#include "raven2_trainer/config/load_training.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "named_files.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_exercise.h"
#include "raven2_trainer/config/load_scene.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestTrainee = 32;   // a name in lists and reports, no more
constexpr const char* kOwnDrill = "own";      // the one that the exercise names
constexpr std::uint64_t kDrillStream = 0xD1;  // of the seed: a number for each attempt, in order

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
  const std::string scene = namedFile(c->scenes, Section::fromFile(file).text("scene"), "scene", {});
  c->files.insert(c->files.end(), {file, scene});
  c->roles = loadScene(scene);
  c->exercise = loadExercise(file, c->roles);
  c->scene_urdf = c->roles.urdf;
  c->urdf_places[c->roles.urdf] = c->roles.urdf_place;
  c->runtime.plan_at = -1.0;  // a path that is shown goes through everything, and what the jaws hold is let go
  const fs::path band = fs::path(c->bands) / (c->exercise_name + ".yaml");
  if (fs::exists(band)) c->files.push_back(band.string());  // what its scores are judged by
}

/** [s] */
double drawJitter(const TrainerConfig& config, std::uint32_t attempt) {
  Random random(config.seed, kDrillStream);
  double jitter = 0.0;
  for (std::uint32_t i = 0; i < attempt; ++i)
    jitter = random.uniform(0.0, config.exercise.drill.jitter);
  return jitter;
}

/** When a drill strikes, and what is right then, stands in the exercise: without that it has none, by whatever name. */
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

bool isDrill(const TrainerConfig& config) noexcept {
  return config.drill != "none" && config.hazard == config.drill;
}

FaultPlan drillPlan(const TrainerConfig& config, std::uint32_t attempt, std::uint64_t generation) {
  FaultPlan plan;
  plan.generation = generation;
  if (!isDrill(config)) return plan;
  plan = planFor(config, faultId(config, config.drill), generation);
  const ExerciseDrill& drill = config.exercise.drill;
  const auto shot = static_cast<Tick>(std::llround((drill.delay + drawJitter(config, attempt)) / kTickSeconds));
  auto* const end = plan.faults.begin() + plan.count;
  const Tick first =
      plan.count == 0 ? 0 : std::min_element(plan.faults.begin(), end, [](const Fault& a, const Fault& b) {
                              return a.first_tick < b.first_tick;
                            })->first_tick;
  std::for_each(plan.faults.begin(), end, [&](Fault& fault) {
    fault.trigger = FaultTrigger::kStep;
    fault.threshold = drill.step;
    fault.first_tick += shot - first;
    fault.period_ticks = 0;
    fault.count = 1;
    fault.probability = 1.0;
  });
  return plan;
}

}  // namespace raven2_trainer::config
