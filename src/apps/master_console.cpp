// The surgeon's hands: both masters' ITP packets at 1 kHz from a script or a recording, moved by the force cue, or from
// haptic devices, which feel it.

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
  apps::MasterOptions real;  ///< scale and duration are the scripted hands', too
};

void tellCounts(const char* what, const LinkCounts& counts) {
  std::fprintf(stderr, "%s: %llu received = %llu applied + %llu rejected\n", what,
               static_cast<unsigned long long>(counts.received), static_cast<unsigned long long>(counts.applied),
               static_cast<unsigned long long>(counts.rejectedTotal()));
}

constexpr double kPoll = 0.1;        // [s]
constexpr double kAfterwards = 1.0;  // [s] what was let go falls and comes to rest

/** @throw ConfigException for hands that have to see, and would not. */
TrainerConfig load(const Options& options) {
  TrainerConfig config = options.common.load();
  if (options.real.scale > 0.0) config.console.scale = options.real.scale;
  if (console::doesExercise(options.motion.motion) && !config.network.sight)
    throw ConfigException("motion is \"" + options.motion.motion + "\", which needs sight: true in network.yaml");
  return config;
}

/** Until a signal, the end of the time, or of the exercise that the hands do. */
void watch(const Options& options, const daemon::ConsoleRunner& console) {
  double rest = console::doesExercise(options.motion.motion) ? kAfterwards : std::numeric_limits<double>::infinity();
  bool told = false, told_signing = false, told_pedals = false;
  for (double time = 0.0; options.real.duration <= 0.0 || time < options.real.duration; time += kPoll) {
    if (apps::waitForSignal(kPoll)) break;
    if (console.finished() && !told) std::fprintf(stderr, "the motion is over; the pedal stays up\n");
    told = console.finished();
    if (console.signing() && !told_signing) std::fprintf(stderr, "the daemon has answered: packets are signed\n");
    told_signing = console.signing();
    if (console.pedalsRefused() && !told_pedals)
      std::fprintf(stderr, "warning: these hands use pedals beside ITP, refused where ITP is signed\n");
    told_pedals = console.pedalsRefused();
    if (told && (rest -= kPoll) < 0.0) break;
  }
}

int run(const Options& options, int argc, char** argv) {
  if (!options.real.master.empty()) return apps::runMaster(options.common.load(), options.real, argc, argv);
  const TrainerConfig config = load(options);
  apps::TruthFile truth(options.motion.truth);
  daemon::ConsoleRunner console(config, console::makeMotion(config, options.motion.choice(), truth.log()));
  console.start(!console::doesExercise(options.motion.motion));
  watch(options, console);
  console.stop();
  truth.write();
  tellCounts("forces", console.forceCounts());
  if (console.sightPort() != 0) tellCounts("pictures", console.sightCounts());
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  Options options;
  CLI::App app{"The surgeon's hands: ITP packets at 1 kHz, force cue applied to a hand model, or to haptic devices."};
  options.common.add(&app, /*with_ports=*/true);
  options.motion.add(&app);
  app.add_option("--master", options.real.master,
                 "Haptic devices in place of --motion: a name in config/masters or a file ending in .yaml")
      ->excludes("--motion");
  app.add_option("--scale", options.real.scale, "Motion scale (default: the configuration's)")
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--duration", options.real.duration,
                 "End after this long [s]; 0: until stopped, or a second after an expert or clumsy hand is finished")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  return apps::runProgram(&app, argc, argv, [&] { return run(options, argc, argv); });
}
