#include "apps/common/command_line.h"

#include "apps/common/csv_table.h"
#include "apps/common/help_format.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
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

/** CLI::Range accepts NaN: every comparison with NaN is false. */
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
  app->add_option("--exercise", training.exercise, "Exercise of config/exercises, or none (default: the configuration's)")
      ->type_name("NAME");
  app->add_option("--hazard", hazard,
                  "Hazard that starts by itself, or none (default: the configuration's; none with --exercise)")
      ->type_name("NAME");
  app->add_option("--drill", training.drill,
                  "Hazard in the exercise, replaces --hazard: own (the exercise's), one of config/faults, or none")
      ->type_name("NAME");
  app->add_option("--trainee", training.trainee, "ID of the trainee: at most 32 of a-z, 0-9, _ and -")->type_name("ID");
  app->add_option("--curriculum", training.curriculum, "Curriculum of config/curricula that the session counts for")
      ->type_name("NAME");
  app->add_option("--seed", seed, "Seed of all random numbers (default: the configuration's)")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 53));
  app->add_option("--config", config, "Root configuration file (default: the packaged config/trainer.yaml)")
      ->type_name("FILE");
  app->add_option("--arm-contacts", arm_contacts, "Whether the model's arms touch the scene (default: the configuration's)")
      ->check(CLI::IsMember({"on", "off"}));
  app->add_option("--plant", plant,
                  "Plant of the virtual Raven: a name of config/plants or a YAML file (default: the configuration's)")
      ->type_name("NAME");
  if (with_ports) addPorts(app);
}

void CommonOptions::ignore(CLI::App* app, std::initializer_list<const char*> names) {
  for (const char* name : names)
    app->get_option(name)->group(kIgnored);
}

void CommonOptions::addPorts(CLI::App* app) {
  const auto port = [&](const char* name, int* value, const char* use, int least) {
    app->add_option(name, *value, use)->type_name("N")->group(kPorts)->check(CLI::Range(least, 65535));
  };
  port("--master-port", &master_port, "UDP, console to daemon", 0);
  port("--robot-port", &robot_port, "UDP, daemon to robot", 1);
  port("--force-port", &force_port, "UDP, daemon to console: forces", 1);
  port("--sight-port", &sight_port, "UDP, daemon to console: poses", 1);
  port("--state-port", &state_port, "TCP, robot to daemon", 1);
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

/** Ends --help with the general meaning of the exit status, unless the program describes its own. */
void describeStatus(CLI::App* app) {
  const auto describes = [](const std::string& text) { return text.find("Exit ") != std::string::npos; };
  if (describes(app->get_description()) || describes(app->get_footer())) return;
  const std::string own = app->get_footer();
  app->footer(own + (own.empty() ? "" : "\n") +
              "Exit status: 0 done, 1 failed (stderr says why), above 100 wrong arguments.");
}

/** Exit status for a wrong table, so that a script can distinguish it from a program that failed. */
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
  describeStatus(app);
  app->formatter(std::make_shared<HelpFormat>());
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
