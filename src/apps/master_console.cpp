// The surgeon's hands: both masters' ITP packets at 1 kHz from a script or a recording, moved by the force cue.

#include <CLI/CLI.hpp>

#include "apps/common/command_line.h"
#include "apps/common/motion_options.h"
#include "apps/common/signals.h"
#include "raven2_trainer/runtime/console_runner.h"
#include "raven2_trainer/runtime/motion.h"

namespace raven2_trainer {
namespace {

struct Options {
  apps::CommonOptions common;
  apps::MotionOptions motion;
  double scale{0.0};
  double duration{0.0};
};

int run(const Options& options) {
  TrainerConfig config = options.common.load();
  if (options.scale > 0.0) config.console.scale = options.scale;
  apps::TruthFile truth(options.motion.truth);
  runtime::ConsoleRunner console(config, runtime::makeMotion(config, options.motion.choice(), truth.log()));
  console.start();
  bool told = false, told_signing = false;
  for (double time = 0.0; options.duration <= 0.0 || time < options.duration; time += 0.1) {
    if (apps::waitForSignal(0.1)) break;
    if (console.finished() && !told) std::fprintf(stderr, "the motion is over; the pedal stays up\n");
    told = console.finished();
    if (console.signing() && !told_signing) std::fprintf(stderr, "the daemon has answered: packets are signed\n");
    told_signing = console.signing();
  }
  console.stop();
  truth.write();
  const LinkCounts forces = console.forceCounts();
  std::fprintf(stderr, "forces: %llu received = %llu applied + %llu rejected\n",
               static_cast<unsigned long long>(forces.received), static_cast<unsigned long long>(forces.applied),
               static_cast<unsigned long long>(forces.rejectedTotal()));
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  Options options;
  CLI::App app{"The surgeon's hands: ITP packets at 1 kHz, force cue applied to a hand model."};
  options.common.add(&app, /*with_ports=*/true);
  options.motion.add(&app);
  app.add_option("--scale", options.scale, "Motion scale (default: the configuration's)")
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--duration", options.duration, "End after this long [s]; 0: until stopped")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  return apps::runProgram(&app, argc, argv, [&] { return run(options); });
}
