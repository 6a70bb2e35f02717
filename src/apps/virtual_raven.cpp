// The virtual Raven: emulated control software on an emulated plant, over the real robot's sockets, or driven by a
// recording in lockstep.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cinttypes>
#include <cstdlib>

#include "apps/common/command_line.h"
#include "apps/common/signals.h"
#include "raven2_trainer/robot/raven_server.h"
#include "raven2_trainer/ros/raven_publisher.h"
#include "raven2_trainer/ros/supervisor.h"
#include "raven2_trainer/studies/replay.h"
#include "raven2_trainer/threads/realtime_check.h"

namespace raven2_trainer {
namespace {

constexpr double kLookEvery = 0.05;  // [s]
constexpr int kCrashed = 139;        // as a shell reports a segmentation fault

struct Options {
  apps::CommonOptions common;
  double duration{0.0};
  std::string homing, behaviour;  ///< the configuration's if empty
  std::string replay, output;
  studies::ReplayOptions replay_options;

  TrainerConfig load() const {
    TrainerConfig config = common.load();
    if (!homing.empty()) config.virtual_raven.full_homing = homing == "full";
    if (!behaviour.empty()) config.virtual_raven.behaviour = behaviour;
    return config;
  }
};

int replay(const Options& options) {
  const TrainerConfig config = options.load();
  apps::ProgressBar bar("replay");
  const auto start = std::chrono::steady_clock::now();
  const studies::ReplaySummary summary = studies::replayFile(config, options.replay_options, options.replay,
                                                             options.output, [&](double share) { bar.update(share); });
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  char text[160];
  std::snprintf(text, sizeof(text),
                "%.1f s in %.1f s (%.0f x real time); ITP %" PRIu64 " received, %" PRIu64 " applied", summary.seconds,
                wall.count(), summary.seconds / wall.count(), summary.itp.received, summary.itp.applied);
  bar.done(text);
  return 0;
}

/** The emulated program has ended, by a fault: nothing is closed or said to anybody, as then. */
[[noreturn]] void crash() {
  std::fprintf(stderr, "the control program crashed (fault)\n");
  std::_Exit(kCrashed);
}

/** Prints the final counts. @return whether they add up. */
bool reportEnd(const robot::RavenServer& server) {
  const RobotState state = server.state();
  const robot::StateServer& link = server.stateServer();
  const net::FrameTotals frames = link.frames();
  std::fprintf(stderr,
               "%" PRIu64 " cycles; ITP %" PRIu64 " received, %" PRIu64 " applied; %" PRIu64
               " frames lost by slow readers\n",
               state.cycle, state.itp.received, state.itp.applied, frames.dropped);
  std::fprintf(stderr,
               "frames: %" PRIu64 " = %" PRIu64 " sent + %" PRIu64 " dropped + %" PRIu64 " unsent + %" PRIu64
               " queued; readers: %" PRIu64 " refused, %" PRIu64 " evicted\n",
               frames.pushed, frames.sent, frames.dropped, frames.unsent, frames.queued, link.readersRefused(),
               link.readersEvicted());
  return state.itp.addsUp() && frames.addsUp();
}

int run(const Options& options, int argc, char** argv) {
  apps::blockSignals();
  const TrainerConfig config = options.load();
  robot::RavenServer server(config);
  ros_bridge::RavenPublisher publisher(config.arms.geometry, config.runtime.enable_remote_control, &server);
  ros_bridge::Supervisor ros(argc, argv, "virtual_raven", &publisher);
  const threads::MemoryLock memory = threads::lockMemory();
  server.start();
  const std::string refusal = server.refusal();
  std::fprintf(stderr, "behaviour %s; %s; %s\n", config.virtual_raven.behaviour.c_str(),
               refusal.empty() ? "SCHED_FIFO" : ("DEGRADED_RT: " + refusal).c_str(), memory.words.c_str());
  ros.start();
  RunLevel shown = RunLevel::kEStop;
  std::uint64_t acted = 0;
  for (double time = 0.0; (options.duration <= 0.0 || time < options.duration) && !apps::waitForSignal(kLookEvery);
       time += kLookEvery) {
    const RobotState state = server.state();
    if (state.program == ProgramState::kCrashed) crash();
    const RunLevel level = state.runlevel;
    if (level != shown) std::fprintf(stderr, "run level %s\n", kRunLevelNames[static_cast<std::size_t>(level)]);
    shown = level;
    const std::uint64_t acts = server.detectorCycles();
    if (acts != acted)
      std::fprintf(stderr, "detector: acted in %" PRIu64 " cycles by cycle %" PRIu64 "\n", acts, state.cycle);
    acted = acts;
  }
  ros.end();
  server.stop();
  const bool adds_up = reportEnd(server);
  if (ros.met()) std::fprintf(stderr, "%" PRIu64 " messages of /ravenstate lost\n", publisher.lost());
  return ros.leave(adds_up ? 0 : 1);
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Emulates a Raven-II robot: control software, motors and arms. Takes the place of the real robot."};
  app.footer("Exit status: 0 done, 1 failed (stderr says why), 139 crashed by a fault, above 100 wrong arguments.");
  options.common.add(&app, /*with_ports=*/true);
  apps::CommonOptions::ignore(&app, {"--exercise", "--hazard", "--drill", "--trainee", "--curriculum", "--seed",
                                     "--arm-contacts", "--master-port", "--force-port", "--sight-port"});
  app.add_option("--duration", options.duration, "Run time [s]; 0: until stopped")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  app.add_option("--homing", options.homing, "full: search the hard stops; quick: start with known joints (default: the configuration's)")
      ->check(CLI::IsMember({"full", "quick"}));
  app.add_option("--behaviour", options.behaviour,
                 "Check packets weakly, as a real Raven, or strictly (default: the configuration's)")
      ->check(CLI::IsMember({"compat", "hardened"}));
  auto* input =
      app.add_option("--replay", options.replay, "Recorded packets (.csv or .csv.gz) instead of sockets and ROS")
          ->type_name("FILE");
  app.add_option("--output", options.output, "Recording of the states to write (.csv or .csv.gz)")
      ->type_name("FILE")
      ->needs(input);
  app.add_flag("--skip-homing", options.replay_options.skip_homing, "Start the replay from the home pose in PEDAL_UP")
      ->needs(input);
  app.add_option("--press-start", options.replay_options.press_start,
                 "Press the start button this long after an E-STOP [s]; negative: never")
      ->capture_default_str()
      ->check(CLI::Range(-1.0, 3600.0))
      ->needs(input);
  input->needs("--output");
  return apps::runProgram(&app, argc, argv,
                          [&] { return options.replay.empty() ? run(options, argc, argv) : replay(options); });
}
