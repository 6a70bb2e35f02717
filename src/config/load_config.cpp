#include "raven2_trainer/config/load_config.h"

#include <algorithm>
#include <filesystem>
#include <type_traits>
#include <utility>

#include "config/readers.h"
#include "raven2_trainer/config/load_impairment.h"
#include "raven2_trainer/config/load_scenario.h"
#include "raven2_trainer/config/load_stream.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/nearest_name.h"
#include "raven2_trainer/faults/arming.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

/** Opens a file and puts overrides into it; what was read, then, is kept, for the session's copy. */
Section openFile(const std::string& path, const Overrides& overrides, TrainerConfig* all) {
  all->files.push_back(path);
  Section root = Section::fromFile(path);
  if (overrides.empty()) return root;
  std::string head;
  for (const Override& each : overrides) {
    root.put(each);
    head += "# " + each.key + ": by " + each.source + "\n";
  }
  all->overridden[path] = head + root.yaml();
  return root;
}

template <typename Config, typename Read>
Config readFile(const std::string& path, const Overrides& overrides, TrainerConfig* all, Read read) {
  Section root = openFile(path, overrides, all);
  Config config{};
  read(root, &config);
  root.finish();
  return config;
}

void readImpairments(const std::string& folder, TrainerConfig* c) {
  c->impairment_names = impairmentNames(folder);
  for (const std::string& name : c->impairment_names) {
    c->files.push_back((fs::path(folder) / (name + ".yaml")).string());
    c->impairments.push_back(loadImpairment(c->files.back()));
  }
}

/** In the folder of network.yaml. */
void readStream(const std::string& folder, TrainerConfig* c) {
  const std::string path = streamFile(folder, c->network.stream);
  if (path.empty()) return;
  c->files.push_back(path);
  c->network.itp.stream = loadStream(path);
}

TrainingNames readTrainingNames(Section& root, const TrainingNames& instead) {
  const auto name = [&](const char* key, const std::string& other) {
    const std::string text = root.text(key);
    return other.empty() ? text : other;
  };
  return {name("exercise", instead.exercise), name("drill", instead.drill), name("trainee", instead.trainee),
          name("curriculum", instead.curriculum)};
}

std::vector<std::string> scenarioFiles(const std::string& folder) {
  if (!fs::is_directory(folder)) throw ConfigException(folder + ":1: no such folder of scenarios");
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());  // ids must not depend on the file system
  return files;
}

/** In the order of the list; a user's own, which have number 0, come last and so change no other's id. */
bool isBefore(const Scenario& a, const Scenario& b) {
  const auto rank = [](const Scenario& s) { return std::make_pair(s.number == 0, s.number); };
  return rank(a) < rank(b);
}

std::vector<Scenario> readScenarios(const std::string& folder, TrainerConfig* all) {
  std::vector<Scenario> scenarios;
  for (const std::string& file : scenarioFiles(folder)) {
    all->files.push_back(file);
    scenarios.push_back(loadScenario(file, 0, all->impairment_names));
  }
  std::stable_sort(scenarios.begin(), scenarios.end(), isBefore);  // of one number: by name, as the files come
  std::uint32_t id = 0;
  for (Scenario& scenario : scenarios) {
    ++id;
    for (Fault& fault : scenario.faults)
      fault.id = id;
  }
  return scenarios;
}

std::string placeOf(Section& root, const fs::path& folder, const char* key) {
  return (folder / root.text(key)).lexically_normal().string();
}

/** Files and folders that are read later. */
void readPlaces(Section& root, const fs::path& folder, TrainerConfig* c) {
  const Neighbour robot = neighbour(folder.string(), root.text("robot_urdf"), "config");
  const Neighbour scene = neighbour(folder.string(), root.text("scene_urdf"), "config");
  c->robot_urdf = robot.path;
  c->scene_urdf = scene.path;
  c->urdf_places = {{robot.path, robot.place}, {scene.path, scene.place}};
  c->exercises = placeOf(root, folder, "exercises");
  c->scenes = placeOf(root, folder, "scenes");
  c->curricula = placeOf(root, folder, "curricula");
  c->bands = placeOf(root, folder, "bands");
}

}  // namespace

TrainerConfig loadTrainerConfig(const std::string& path, const TrainingNames& instead, const Overrides& overrides) {
  checkOverrides(overrides);
  TrainerConfig c;
  Section root = openFile(path, overridesOfRoot(overrides), &c);
  const fs::path folder = fs::absolute(path).parent_path();
  const auto file = [&](const char* key) { return placeOf(root, folder, key); };
  const auto read = [&](const char* key, auto* part, auto reader) {
    using Part = std::remove_pointer_t<decltype(part)>;
    *part = readFile<Part>(file(key), overridesOf(overrides, key), &c, reader);
  };
  read("arms", &c.arms, readArms);
  read("model", &c.model, readModel);
  read("haptics", &c.haptics, readHaptics);
  read("network", &c.network, [&c](Section& section, NetworkConfig* network) {
    readNetwork(section, c.haptics, network);  // a force must end in time
  });
  readStream((fs::absolute(file("network")).parent_path() / "streams").string(), &c);
  read("runtime", &c.runtime, readRuntime);
  read("planner", &c.planner, readPlanner);
  read("execution", &c.execution, readExecution);
  read("crtk", &c.crtk, readCrtk);
  read("render", &c.render, readRender);
  read("console", &c.console, readConsole);
  read("virtual_raven", &c.virtual_raven, readVirtualRaven);
  c.virtual_raven.itp = c.network.itp;
  selectPlant(&c, c.virtual_raven.plant_name);
  read("injection", &c.injection, readInjection);
  read("detector", &c.detector, readDetector);
  readImpairments(file("impairments"), &c);
  c.scenarios = readScenarios(file("faults"), &c);
  readPlaces(root, folder, &c);
  const TrainingNames names = readTrainingNames(root, instead);
  c.hazard = root.text("hazard");
  c.seed = static_cast<std::uint64_t>(root.integer("seed", 0, std::int64_t{1} << 53));
  root.finish();
  checkHazard(c);
  loadTraining(names, &c);
  return c;
}

OverlaySet overlaysOf(const std::vector<std::string>& names) {
  OverlaySet set;
  if (names.size() == 1 && names[0] == "all") return OverlaySet::all();
  if (names.size() == 1 && names[0] == "none") return set;
  for (const std::string& name : names) {
    const auto found = std::find(kOverlayNames.begin(), kOverlayNames.end(), name);
    if (found == kOverlayNames.end())
      throw ConfigException(unknownName("overlay", name, {kOverlayNames.begin(), kOverlayNames.end()}));
    set.add(static_cast<OverlayKind>(found - kOverlayNames.begin()));
  }
  return set;
}

ArmGeometry toolGeometry(const ArmsConfig& arms, const std::string& name) {
  std::vector<std::string> known;
  for (const ToolPreset& tool : arms.tools) {
    if (tool.name == name) {
      ArmGeometry geometry = arms.geometry;
      geometry.d4 = tool.d4;
      geometry.lw = tool.lw;
      return geometry;
    }
    known.push_back(tool.name);
  }
  throw ConfigException(unknownName("tool", name, known));
}

void selectPlant(TrainerConfig* config, const std::string& name) {
  VirtualRavenConfig& robot = config->virtual_raven;
  const auto fileOf = [&](const std::string& plant) {
    const bool is_file = fs::path(plant).extension() == ".yaml";
    return is_file ? plant : (fs::path(robot.plants_folder) / (plant + ".yaml")).string();
  };
  auto& files = config->files;
  files.erase(std::remove(files.begin(), files.end(), fileOf(robot.plant_name)), files.end());
  robot.plant = readFile<PlantConfig>(fileOf(name), {}, config, readPlant);
  robot.plant_name = name;
}

std::uint32_t faultId(const TrainerConfig& config, const std::string& name) {
  const std::uint32_t id = faults::idOf(config.scenarios, name);
  if (id != 0 || name == "none") return id;
  std::vector<std::string> known{"none"};
  for (const Scenario& scenario : config.scenarios)
    known.push_back(scenario.name);
  throw ConfigException(unknownName("hazard", name, known));
}

void checkHazard(const TrainerConfig& config) {
  if (faultId(config, config.hazard) != 0 && !config.injection.enable)
    throw ConfigException("hazard " + config.hazard + " is to be armed, but injection.yaml does not enable it");
}

}  // namespace raven2_trainer::config
