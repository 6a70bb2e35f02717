// Sends both masters' ITP packets at 1 kHz: of a simulated surgeon, whose hands the forces push, or of haptic devices,
// which get the forces.

#include <CLI/CLI.hpp>
#include <limits>

#include "apps/common/command_line.h"
#include "apps/common/motion_options.h"
#include "apps/common/signals.h"
#include "apps/master/run_master.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/daemon/console_runner.h"

namespace raven2_trainer {
namespace {

struct Options {
  apps::CommonOptions common;
  apps::MotionOptions motion;
  apps::MasterOptions real;  ///< scale and duration also hold for the simulated surgeon
};

void printCounts(const char* what, const LinkCounts& counts) {
  std::fprintf(stderr, "%s: %llu received = %llu applied + %llu rejected\n", what,
               static_cast<unsigned long long>(counts.received), static_cast<unsigned long long>(counts.applied),
               static_cast<unsigned long long>(counts.rejectedTotal()));
}

constexpr double kPoll = 0.1;        // [s]
constexpr double kAfterwards = 1.0;  // [s] until objects that were released lie still

/** @throw ConfigException for a simulated surgeon who needs pictures, if network.yaml switches them off. */
TrainerConfig load(const Options& options) {
  TrainerConfig config = options.common.load();
  if (options.real.scale > 0.0) config.console.scale = options.real.scale;
  if (console::doesExercise(options.motion.motion) && !config.network.sight)
    throw ConfigException("motion is \"" + options.motion.motion + "\", which needs sight: true in network.yaml");
  return config;
}

/** Waits for a signal, the end of the time, or the end of the simulated surgeon's exercise. */
void watch(const Options& options, const daemon::ConsoleRunner& console) {
  double rest = console::doesExercise(options.motion.motion) ? kAfterwards : std::numeric_limits<double>::infinity();
  bool is_over = false, has_signed = false, has_warned = false;
  for (double time = 0.0; options.real.duration <= 0.0 || time < options.real.duration; time += kPoll) {
    if (apps::waitForSignal(kPoll)) break;
    if (console.finished() && !is_over) std::fprintf(stderr, "the motion is over; the pedal stays up\n");
    is_over = console.finished();
    if (console.signing() && !has_signed) std::fprintf(stderr, "the daemon has answered: packets are signed\n");
    has_signed = console.signing();
    if (console.pedalsRefused() && !has_warned)
      std::fprintf(stderr, "warning: this simulated surgeon uses pedals outside of ITP; the daemon refuses them because ITP is signed\n");
    has_warned = console.pedalsRefused();
    if (is_over && (rest -= kPoll) < 0.0) break;
  }
}

int run(const Options& options, int argc, char** argv) {
  if (!options.real.master.empty()) return apps::runMaster(options.common.load(), options.real, argc, argv);
  const TrainerConfig config = load(options);
  if (console::isCommanded(options.motion.motion))
    throw ConfigException("motion is \"" + options.motion.motion + "\": only simulate repeats the commands of a file");
  apps::TruthFile truth(options.motion.truth);
  daemon::ConsoleRunner console(config, console::makeMotion(config, options.motion.choice(), truth.log()));
  console.start(!console::doesExercise(options.motion.motion));
  watch(options, console);
  console.stop();
  truth.write();
  printCounts("forces", console.forceCounts());
  if (console.sightPort() != 0) printCounts("pictures", console.sightCounts());
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  Options options;
  CLI::App app{"Sends hand motion to the trainer: from haptic devices, a recording or a simulated surgeon."};
  options.motion.add(&app);
  app.add_option("--master", options.real.master,
                 "Haptic devices: a name of config/masters or a file that ends in .yaml")
      ->excludes("--motion");
  options.common.add(&app, /*with_ports=*/true);
  apps::CommonOptions::ignore(&app, {"--hazard", "--drill", "--trainee", "--curriculum", "--arm-contacts", "--plant",
                                     "--robot-port", "--state-port"});
  app.add_option("--scale", options.real.scale, "Motion scale (default: the device's, or the configuration's)")
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--duration", options.real.duration,
                 "Run time [s]; 0: until stopped; expert and clumsy end 1 s after the exercise")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  return apps::runProgram(&app, argc, argv, [&] { return run(options, argc, argv); });
}
