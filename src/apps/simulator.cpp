// The daemon on the surgeon's console host: nominal model, haptic cue, relay, faults, planner, pictures, record, ROS.

#include <CLI/CLI.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/paths.h"
#include "apps/common/signals.h"
#include "raven2_trainer/ros/ros_bridge.h"
#include "raven2_trainer/ros/supervisor.h"
#include "raven2_trainer/runtime/finish_session.h"
#include "raven2_trainer/runtime/simulator.h"

namespace raven2_trainer {
namespace {

using runtime::Simulator;
using runtime::SimulatorState;

/** Until the session is over or somebody ends it. @return true if it ended as it should. */
bool watch(const Simulator& simulator, double duration) {
  apps::ProgressBar bar("session");
  for (;;) {
    const bool interrupted = apps::waitForSignal(0.05);
    const ModelState model = simulator.shared().model.load();
    const double time = static_cast<double>(model.session_tick < 0 ? 0 : model.session_tick) * kTickSeconds;
    char detail[96];
    std::snprintf(detail, sizeof(detail), "%.1f s, %s", time, kModeNames[static_cast<std::size_t>(model.mode)]);
    const SimulatorState state = simulator.state();
    if (state == SimulatorState::kRunning && !interrupted) {
      if (duration > 0.0) bar.update(time / duration, detail);
      continue;
    }
    const char* ends[] = {"stopped", "complete", "no pedal-down before the start time-out"};
    bar.done(std::string(ends[static_cast<std::size_t>(state)]) + " at " + detail);
    return state == SimulatorState::kComplete || (interrupted && state == SimulatorState::kRunning);
  }
}

/** What of the configuration has an option of its own. */
struct Overrides {
  std::string robot_host;
  double scale{0.0};
};

int run(const apps::CommonOptions& common,
        const Overrides& overrides,
        const runtime::SimulatorOptions& options,
        int argc,
        char** argv) {
  TrainerConfig config = common.load();
  if (!overrides.robot_host.empty()) config.network.robot_host = overrides.robot_host;
  if (overrides.scale > 0.0) config.console.scale = overrides.scale;
  Simulator simulator(config, options);
  ros_bridge::RosBridge bridge(&simulator);
  ros_bridge::Supervisor ros(argc, argv, "raven2_simulator", &bridge);
  ros.start();
  simulator.start();
  const bool good = watch(simulator, options.duration);
  ros.end();
  simulator.stop();
  bool given_up = false;  // a second signal: nobody wants to wait
  const auto interrupted = [&] { return given_up = given_up || apps::waitForSignal(0.0); };
  const bool scored = simulator.recorded() && runtime::finishSession(simulator.paths(), interrupted);
  return ros.leave(good && (scored || given_up) ? 0 : 1);
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  apps::CommonOptions common;
  runtime::SimulatorOptions options;
  options.version = apps::version();
  CLI::App app{"The training daemon: model, haptic cue, relay, faults, planner, pictures, record, ROS."};
  common.add(&app, /*with_ports=*/true);
  Overrides overrides;
  app.add_option("--robot-host", overrides.robot_host, "IPv4 address of the robot (default: the configuration's)")
      ->check(CLI::ValidIPV4);
  app.add_option("--scale", overrides.scale, "Motion scale of the surgeon's master (default: the configuration's)")
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--duration", options.duration, "Session time from the first pedal down [s]; 0: until stopped")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  app.add_option("--output", options.output, "Session directory (default: sessions/<UTC stamp>)");
  app.add_option("--motion-label", options.motion, "What the console plays, for the record only");
  app.add_flag("--strict", options.strict, "Refuse to start where real time or the files cannot be trusted");
  app.add_flag("!--no-render", options.render, "No live picture");
  return apps::runProgram(&app, argc, argv, [&] { return run(common, overrides, options, argc, argv); });
}
