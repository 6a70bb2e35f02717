#include "apps/common/command_line.h"

#include "apps/common/csv_table.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/common/paths.h"
#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer::apps {
namespace {

constexpr int kBarWidth = 30;

std::vector<std::string> withoutRemappings(int argc, char** argv) {
  std::vector<std::string> arguments;
  for (int i = argc - 1; i > 0; --i) {  // CLI11 takes them last first
    if (std::string(argv[i]).find(":=") == std::string::npos) arguments.emplace_back(argv[i]);
  }
  return arguments;
}

bool isNan(const std::string& word) {
  char* end = nullptr;
  return std::isnan(std::strtod(word.c_str(), &end)) && *end == '\0';
}

/** CLI::Range lets NaN through: every comparison with it is false. */
void refuseNan(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_type_name().find("FLOAT") == std::string::npos) continue;
    const std::vector<std::string>& values = option->results();
    const auto bad = std::find_if(values.begin(), values.end(), isNan);
    if (bad == values.end()) continue;
    throw CLI::ValidationError(option->get_name(), "value " + std::to_string(bad - values.begin() + 1) + " is " + *bad +
                                                       ", expected a number");
  }
}

void setPort(int option, std::uint16_t* port) {
  if (option >= 0) *port = static_cast<std::uint16_t>(option);
}

}  // namespace

void CommonOptions::add(CLI::App* app, bool with_ports) {
  app->add_option("--config", config, "Root configuration file (default: the packaged config/trainer.yaml)");
  app->add_option("--hazard", hazard,
                  "Hazard scenario to arm, or none (default: the configuration's); a drill takes its place");
  app->add_option("--exercise", training.exercise,
                  "Exercise (config/exercises), in the scene that it asks for, or none (default: the configuration's)");
  app->add_option("--drill", training.drill,
                  "Hazard that the exercise runs into: own, a scenario (config/faults), none");
  app->add_option("--trainee", training.trainee, "Id of whoever is trained: at most 32 of a-z, 0-9, _ and -");
  app->add_option("--curriculum", training.curriculum, "Curriculum (config/curricula) that the session belongs to");
  app->add_option("--seed", seed, "Seed of everything random (default: the configuration's)")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 53));
  app->add_option("--arm-contacts", arm_contacts, "Let the model's arms touch the scene (default: the configuration's)")
      ->check(CLI::IsMember({"on", "off"}));
  app->add_option("--plant", plant,
                  "Preset of the virtual Raven's plant (config/plants) or a YAML file (default: the configuration's)");
  if (!with_ports) return;
  app->add_option("--master-port", master_port, "UDP port console -> daemon")->check(CLI::Range(0, 65535));
  app->add_option("--robot-port", robot_port, "UDP port daemon -> robot")->check(CLI::Range(1, 65535));
  app->add_option("--force-port", force_port, "UDP port daemon -> console")->check(CLI::Range(1, 65535));
  app->add_option("--sight-port", sight_port, "UDP port daemon -> console, pictures")->check(CLI::Range(1, 65535));
  app->add_option("--state-port", state_port, "TCP port robot -> daemon")->check(CLI::Range(1, 65535));
}

TrainerConfig CommonOptions::load(const config::Overrides& overrides) const {
  TrainerConfig loaded = config::loadTrainerConfig(config.empty() ? defaultConfigPath() : config, training, overrides);
  if (!hazard.empty() && loaded.drill == "none") {
    loaded.hazard = hazard;
    config::checkHazard(loaded);
  }
  if (!plant.empty()) config::selectPlant(&loaded, plant);
  if (seed >= 0) loaded.seed = static_cast<std::uint64_t>(seed);
  if (!arm_contacts.empty()) loaded.model.arm_contacts.fill(arm_contacts == "on");
  setPort(master_port, &loaded.network.master_port);
  setPort(robot_port, &loaded.network.robot_port);
  setPort(force_port, &loaded.network.force_port);
  setPort(sight_port, &loaded.network.sight_port);
  setPort(state_port, &loaded.network.state_port);
  return loaded;
}

/** What --help ends with where a program has nothing of its own to say about its status. */
void tellStatus(CLI::App* app) {
  const auto tells = [](const std::string& text) { return text.find("Exit ") != std::string::npos; };
  if (tells(app->get_description()) || tells(app->get_footer())) return;
  const std::string own = app->get_footer();
  app->footer(own + (own.empty() ? "" : "\n") +
              "Exit status: 0 done, 1 failed with a line on stderr that says why, above 100 wrong arguments.");
}

/** Exit status for a table that is wrong, so that a script can tell it from a program that failed. */
constexpr int kBadTable = 2;

std::string describeSession(const TrainerConfig& config, const std::string& driver) {
  const bool is_free = config.exercise_name == "none";
  const std::string what = is_free ? "free session, hazard " + config.hazard
                                   : "exercise " + config.exercise_name + ", drill " + config.drill;
  return what + ", trainee " + (config.trainee.empty() ? "none" : config.trainee) + ", driver " +
         (driver.empty() ? "not named" : driver);
}

void within(CLI::Option* option, int least, int most) {
  option->capture_default_str()->check(CLI::Range(least, most));
}

void within(CLI::Option* option, double least, double most) {
  option->capture_default_str()->check(CLI::Range(least, most));
}

int runProgram(CLI::App* app, int argc, char** argv, const std::function<int()>& body) {
  app->set_version_flag("--version", version());
  tellStatus(app);
  app->name(std::filesystem::path(argv[0]).filename().string());
  try {
    app->parse(withoutRemappings(argc, argv));
    refuseNan(*app);
  } catch (const CLI::ParseError& e) {
    return app->exit(e);
  }
  try {
    return body();
  } catch (const CsvException& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return kBadTable;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}

ProgressBar::ProgressBar(std::string label) : label_(std::move(label)), terminal_(isatty(STDERR_FILENO) == 1) {}

void ProgressBar::update(double share, const std::string& detail) {
  const int percent = static_cast<int>(std::clamp(share, 0.0, 1.0) * 100.0);
  if (!terminal_) {
    if (percent / 25 <= shown_ / 25 && shown_ >= 0) return;
    shown_ = percent;
    std::fprintf(stderr, "%s %d %% %s\n", label_.c_str(), percent, detail.c_str());
    return;
  }
  const int filled = percent * kBarWidth / 100;
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kBarWidth - filled), '.');
  std::fprintf(stderr, "\r%s [%s] %3d %% %s\033[K", label_.c_str(), bar.c_str(), percent, detail.c_str());
  std::fflush(stderr);
}

void ProgressBar::done(const std::string& detail) {
  std::fprintf(stderr, "%s%s: %s%s\n", terminal_ ? "\r" : "", label_.c_str(), detail.c_str(),
               terminal_ ? "\033[K" : "");
}

}  // namespace raven2_trainer::apps
