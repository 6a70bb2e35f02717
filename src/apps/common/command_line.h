#pragma once

#include <functional>
#include <initializer_list>
#include <string>

#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/config/overrides.h"
#include "raven2_trainer/config/trainer_config.h"

namespace CLI {
class App;
class Option;
}

namespace raven2_trainer::apps {

/** Options of several programs: add() registers them, load() reads the configuration and applies them. */
struct CommonOptions {
  std::string config;                ///< --config FILE; the packaged one if empty
  std::string hazard;                ///< --hazard NAME|none; config's if empty
  std::int64_t seed{-1};             ///< --seed N; config's if negative
  std::string arm_contacts;          ///< --arm-contacts on|off; config's if empty
  std::string plant;                 ///< --plant NAME|FILE; config's if empty
  config::TrainingNames training{};  ///< --exercise, ...; config's if empty
  int master_port{-1}, robot_port{-1}, force_port{-1}, sight_port{-1}, state_port{-1};  ///< config's if negative

  void add(CLI::App* app, bool with_ports);
  void addPorts(CLI::App* app);
  /** Options that the program accepts, as launch files give them to all, and does not use: --help has them last. */
  static void ignore(CLI::App* app, std::initializer_list<const char*> names);
  /** @param[in] overrides of the files' values; options go before them. @throw ConfigException. */
  TrainerConfig load(const config::Overrides& overrides = {}) const;
};

/** Sets the option's range; --help shows it and the default. */
void within(CLI::Option* option, int least, int most);
void within(CLI::Option* option, double least, double most);

/** A session in words: `exercise peg_transfer, drill sudden_jump, trainee tim, driver expert`. */
std::string describeSession(const TrainerConfig& config, const std::string& driver);

/**
 * Parses the arguments, without ROS remappings NAME:=VALUE, and calls `body`. Prints an exception as one line on stderr.
 * @return the exit code: that of body, 1 after an exception, CLI11's for --help and wrong arguments. --help explains
 * these codes, unless the program's description or footer has "Exit status".
 */
int runProgram(CLI::App* app, int argc, char** argv, const std::function<int()>& body);

/** A progress bar on stderr: redrawn in place on a terminal, a line every 25 % otherwise. */
class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  void update(double share, const std::string& detail = "");
  void done(const std::string& detail);

 private:
  std::string label_;
  bool terminal_;
  int shown_{-1};
};

}  // namespace raven2_trainer::apps
