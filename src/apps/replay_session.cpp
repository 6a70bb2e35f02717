// replay_session DIR: a recorded session as ROS topics, with /clock.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/session_config.h"
#include "apps/common/signals.h"
#include "raven2_trainer/ros/session_replay.h"
#include "raven2_trainer/ros/supervisor.h"
#include "raven2_trainer/session/session_directory.h"

namespace raven2_trainer {
namespace {

constexpr double kMasterTimeout = 5.0;  // [s]
constexpr double kLookEvery = 0.05;     // [s]
constexpr double kGoodbye = 0.3;        // [s] what was published last is sent before the connections close

struct Options {
  std::string directory, config;
  double delay{0.5};
  ros_bridge::SessionReplayOptions replay;
};

void addOptions(CLI::App* app, Options* o) {
  app->add_option("DIR", o->directory, "Session directory, with session.rlog")->required();
  app->add_option("--rate", o->replay.rate, "Speed; 2 is twice as fast as the session")
      ->check(CLI::Range(0.1, 20.0))
      ->capture_default_str();
  app->add_option("--from", o->replay.from, "Session time to start from [s] (default: the log's start, before time 0)")
      ->check(CLI::Range(0.0, 1e6));
  app->add_flag("--loop", o->replay.loop, "Start again at the end; /clock then jumps back");
  app->add_option("--delay", o->delay, "Time before the first message, for subscribers to connect [s]")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  app->add_flag("--set-sim-time", o->replay.set_sim_time, "Set the parameter /use_sim_time to true");
  app->add_option("--config", o->config,
                  "Root configuration file (default: the session's own copy, and the packaged config/render.yaml)")
      ->type_name("FILE");
}

enum class Ready { kYes, kNo, kSignal };

/** Is there a master, with simulated time? Says why not. */
Ready awaitMaster(const ros_bridge::Supervisor& ros, const ros_bridge::SessionReplay& replay) {
  for (double waited = 0.0; !ros.met(); waited += kLookEvery) {
    if (apps::waitForSignal(kLookEvery)) return Ready::kSignal;
    if (waited < kMasterTimeout) continue;
    std::fprintf(stderr, "no ROS master answers: start roscore, or set ROS_MASTER_URI\n");
    return Ready::kNo;
  }
  if (!replay.isRefused()) return Ready::kYes;
  std::fprintf(stderr,
               "the parameter /use_sim_time is not true: programs would take the session's stamps for their own time.\n"
               "Before they start: rosparam set use_sim_time true, or replay_session --set-sim-time\n");
  return Ready::kNo;
}

int run(const Options& o, int argc, char** argv) {
  const session::SessionPaths paths = session::openSessionDirectory(o.directory);
  ros_bridge::SessionReplay replay(apps::viewingConfig(paths, o.config), paths, o.replay);
  ros_bridge::Supervisor ros(argc, argv, "replay_session", &replay);
  ros.start();
  const Ready ready = awaitMaster(ros, replay);
  if (ready != Ready::kYes) return ros.leave(ready == Ready::kNo ? 1 : 0);
  if (apps::waitForSignal(o.delay)) return ros.leave(0);
  const std::uint64_t published = replay.play([](double seconds) { return apps::waitForSignal(seconds); });
  apps::waitForSignal(kGoodbye);
  std::fprintf(stderr, "replay_session: %llu messages of each state\n", static_cast<unsigned long long>(published));
  return ros.leave(0);
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  CLI::App app{"Publishes a recorded session on ROS: the daemon's topics, /tf and /clock, with the log's time stamps."};
  app.footer(
      "Needs the parameter /use_sim_time, true before subscribers start. Do not run it together with a daemon: the\n"
      "topics are the same. Exit status: 0 the end of the log or a signal, else failed.");
  Options options;
  addOptions(&app, &options);
  return apps::runProgram(&app, argc, argv, [&] { return run(options, argc, argv); });
}
