// Whether this machine can keep the daemon's two 1 kHz loops: bare threads first, then the loops themselves, both arms
// moving in contact, no sockets.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>

#include "apps/common/command_line.h"
#include "apps/common/signals.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/runtime/driven_loops.h"
#include "raven2_trainer/runtime/realtime_check.h"
#include "raven2_trainer/runtime/timing_report.h"

namespace raven2_trainer {
namespace {

struct Options {
  apps::CommonOptions common;
  double duration{10.0}, calibrate{5.0};  // [s]
  std::string json;
};

/** Lets the loops run. @throw Exception at a signal: half a measurement is none. */
template <typename Loops>
void observe(Loops* loops, double seconds, const std::string& label) {
  constexpr double kStep = 0.1;  // [s]
  apps::ProgressBar bar(label);
  loops->start();
  for (double time = 0.0; time < seconds; time += kStep) {
    bar.update(time / seconds);
    if (apps::waitForSignal(std::min(kStep, seconds - time))) throw Exception("interrupted");
  }
  loops->stop();
  bar.done("");
}

int check(const Options& options) {
  const TrainerConfig config = options.common.load();
  const runtime::MemoryLock memory = runtime::lockMemory();
  physics::initialiseOde();
  std::printf("%s\n", memory.words.c_str());
  for (const std::string& reason : runtime::schedulingReasons(config.runtime))
    std::printf("%s\n", reason.c_str());
  runtime::BareLoops bare(config);
  observe(&bare, options.calibrate, "calibration");
  runtime::DrivenLoops loops(config);
  observe(&loops, options.duration, "loops");
  bool pass = true;
  nlohmann::ordered_json json;
  for (const LoopId id : {LoopId::kPhysics, LoopId::kHaptic}) {
    const std::string name = kLoopNames[static_cast<std::size_t>(id)];
    std::printf("%s", runtime::timingText(name, loops.timing(id), bare.timing(id)).c_str());
    json[name] = runtime::timingJson(loops.timing(id), bare.timing(id));
    pass = pass && runtime::judgeTiming(loops.timing(id), bare.timing(id)).pass;
  }
  if (!options.json.empty() && !(std::ofstream(options.json) << json.dump(2) << '\n')) {
    throw Exception(options.json + ": cannot be written");
  }
  return pass ? 0 : 1;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  Options options;
  CLI::App app{"Measures whether this machine keeps the 1 kHz loops. Exit code 0: yes, beside bare threads."};
  options.common.add(&app, /*with_ports=*/false);
  app.add_option("--duration", options.duration, "Length of the measurement [s]")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 86400.0));
  app.add_option("--calibrate", options.calibrate, "Length of the calibration with bare threads [s]")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 3600.0));
  app.add_option("--json", options.json, "File to write the figures to");
  return apps::runProgram(&app, argc, argv, [&] { return check(options); });
}
