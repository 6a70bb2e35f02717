// The daemon on the surgeon's console host: model, haptics, relay, faults, planner, pictures, recording, ROS.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/paths.h"
#include "apps/common/signals.h"
#include "raven2_trainer/daemon/simulator.h"
#include "raven2_trainer/recording/finish_session.h"
#include "raven2_trainer/ros/parameters.h"
#include "raven2_trainer/ros/ros_bridge.h"
#include "raven2_trainer/ros/supervisor.h"
#include "raven2_trainer/wire/stream_watch.h"

namespace raven2_trainer {
namespace {

using daemon::Simulator;
using daemon::SimulatorState;

constexpr const char* kNode = "raven2_simulator";

/** Prints once why most packets of a console are rejected: otherwise nobody sees why nothing moves. */
void reportRefusedConsole(const Simulator& simulator, std::uint32_t* reported) {
  const StreamFinding finding = simulator.shared().master_stream.load();
  if (finding.number == *reported) return;
  *reported = finding.number;
  std::fprintf(stderr, "\nraven2_trainer: %s\n", wire::sentence(finding).c_str());
}

/** Waits for the end of the session or a signal. @return true if it ended as it should. */
bool watch(const Simulator& simulator, double duration) {
  apps::ProgressBar bar("session");
  std::uint32_t reported = 0;
  for (;;) {
    const bool interrupted = apps::waitForSignal(0.05);
    reportRefusedConsole(simulator, &reported);
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

/** Options for single keys of the configuration. They override ROS parameters. */
struct KeyOptions {
  std::string robot_host, scale;

  void addTo(config::Overrides* overrides) const {
    if (!robot_host.empty()) overrides->push_back({"network/robot_host", robot_host, "--robot-host"});
    if (!scale.empty()) overrides->push_back({"console/scale", scale, "--scale"});
  }
};

int run(const apps::CommonOptions& common,
        const KeyOptions& keys,
        const daemon::SimulatorOptions& options,
        int argc,
        char** argv) {
  const config::Overrides parameters = ros_bridge::nodeParameters(argc, argv, kNode);
  config::Overrides overrides = parameters;
  keys.addTo(&overrides);
  const TrainerConfig config = common.load(overrides);
  ros_bridge::checkParameters(parameters, config.runtime.enable_remote_control);
  Simulator simulator(config, options);
  ros_bridge::RosBridge bridge(&simulator);
  ros_bridge::Supervisor ros(argc, argv, kNode, &bridge);
  std::fprintf(stderr, "session: %s\n", apps::describeSession(config, options.motion).c_str());
  ros.start();
  simulator.start();
  const bool good = watch(simulator, options.duration);
  ros.end();
  simulator.stop();
  bool given_up = false;  // by a second signal
  const auto interrupted = [&] { return given_up = given_up || apps::waitForSignal(0.0); };
  const bool scored = simulator.recorded() && recording::finishSession(simulator.paths(), interrupted);
  return ros.leave(good && (scored || given_up) ? 0 : 1);
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  apps::CommonOptions common;
  daemon::SimulatorOptions options;
  options.version = apps::version();
  CLI::App app{"The training daemon: runs the model of the robot, the forces, the hazards and the recording of a session."};
  common.add(&app, /*with_ports=*/true);
  KeyOptions keys;
  app.add_option("--robot-host", keys.robot_host, "IPv4 address of the robot (default: the configuration's)")
      ->check(CLI::ValidIPV4);
  app.add_option("--scale", keys.scale, "Motion scale of the surgeon's master (default: the configuration's)")
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--duration", options.duration, "Session time from the first pedal-down [s]; 0: until stopped")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  app.add_option("--output", options.output, "Session directory (default: sessions/<UTC stamp>)")->type_name("DIR");
  app.add_option("--motion-label", options.motion, "Who moves the arms, in words, for the record only")
      ->type_name("TEXT");
  app.add_flag(
      "--strict", options.strict,
      "Refuse to start without real-time priority and locked memory, with preloaded libraries, or with files that "
      "others can change");
  app.add_flag("!--no-render", options.render, "No live picture");
  return apps::runProgram(&app, argc, argv, [&] { return run(common, keys, options, argc, argv); });
}
