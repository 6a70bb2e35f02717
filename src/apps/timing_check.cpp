// Measures whether this computer keeps the daemon's two 1 kHz loops: first empty threads, then the loops themselves with both
// arms moving in contact, without sockets. Or the empty threads alone, while a session or another program runs.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <fstream>

#include "apps/common/command_line.h"
#include "apps/common/signals.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/daemon/driven_loops.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/recording/timing_report.h"
#include "raven2_trainer/threads/realtime_check.h"

namespace raven2_trainer {
namespace {

struct Options {
  apps::CommonOptions common;
  double duration{10.0}, calibrate{5.0};  // [s]
  bool only_bare{false};
  std::string json;
};

/** Lets the loops run. @return false if a signal ended it early. */
template <typename Loops>
bool observe(Loops* loops, double seconds, const std::string& label) {
  constexpr double kStep = 0.1;  // [s]
  apps::ProgressBar bar(label);
  bool whole = true;
  loops->start();
  for (double time = 0.0; whole && time < seconds; time += kStep) {
    bar.update(time / seconds);
    whole = !apps::waitForSignal(std::min(kStep, seconds - time));
  }
  loops->stop();
  bar.done("");
  return whole;
}

void write(const std::string& path, const nlohmann::ordered_json& json) {
  if (!path.empty() && !(std::ofstream(path) << json.dump(2) << '\n' << std::flush))
    throw Exception(path + ": cannot be written");
}

constexpr std::array kLoops{LoopId::kPhysics, LoopId::kHaptic};
std::string nameOf(LoopId id) {
  return kLoopNames[static_cast<std::size_t>(id)];
}

/** Measures empty threads. A signal ends it: the length of a session next to it is not known. */
int measureBare(const Options& options, const TrainerConfig& config) {
  daemon::BareLoops bare(config);
  observe(&bare, options.calibrate, "bare threads");
  nlohmann::ordered_json json;
  for (const LoopId id : kLoops) {
    std::printf("%s", recording::timingText(nameOf(id), bare.timing(id), bare.timing(id)).c_str());
    json[nameOf(id)] = recording::timingJson(bare.timing(id), bare.timing(id));
  }
  write(options.json, json);
  return 0;
}

int check(const Options& options) {
  const TrainerConfig config = options.common.load();
  const threads::MemoryLock memory = threads::lockMemory();
  physics::initialiseOde();
  std::printf("%s\n", memory.words.c_str());
  for (const std::string& reason : threads::schedulingReasons(config.runtime))
    std::printf("%s\n", reason.c_str());
  if (options.only_bare) return measureBare(options, config);
  daemon::BareLoops bare(config);
  daemon::DrivenLoops loops(config);
  if (!observe(&bare, options.calibrate, "calibration") || !observe(&loops, options.duration, "loops")) {
    throw Exception("interrupted");  // half a measurement is worthless
  }
  bool pass = true;
  nlohmann::ordered_json json;
  for (const LoopId id : kLoops) {
    std::printf("%s", recording::timingText(nameOf(id), loops.timing(id), bare.timing(id)).c_str());
    json[nameOf(id)] = recording::timingJson(loops.timing(id), bare.timing(id));
    pass = pass && recording::judgeTiming(loops.timing(id), bare.timing(id)).pass;
  }
  write(options.json, json);
  return pass ? 0 : 1;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  Options options;
  CLI::App app{
      "Measures whether this computer is fast enough for the 1 kHz loops. Exit status: 0 yes or --bare, else no."};
  options.common.add(&app, /*with_ports=*/false);
  apps::CommonOptions::ignore(&app, {"--hazard", "--drill", "--trainee", "--curriculum", "--seed", "--plant"});
  apps::within(app.add_option("--duration", options.duration, "Length of the measurement [s]"), 1.0, 86400.0);
  apps::within(app.add_option("--calibrate", options.calibrate, "Length of the comparison with bare threads [s]"), 1.0,
               3600.0);
  app.add_flag("--bare", options.only_bare, "Only bare, idle threads, for --calibrate seconds or until a signal");
  app.add_option("--json", options.json, "JSON file to write the figures to")->type_name("FILE");
  return apps::runProgram(&app, argc, argv, [&] { return check(options); });
}
