// The robot when there is none: emulated Raven control software on an emulated plant, over the real robot's sockets.

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/common/command_line.h"
#include "apps/common/signals.h"
#include "raven2_trainer/ros/raven_publisher.h"
#include "raven2_trainer/ros/ros_bridge.h"
#include "raven2_trainer/runtime/cyclic_thread.h"
#include "raven2_trainer/runtime/raven_server.h"

namespace raven2_trainer {
namespace {

constexpr double kReportEvery = 1.0;  // [s]

int run(const apps::CommonOptions& common, double duration, int argc, char** argv) {
  const TrainerConfig config = common.load();
  const bool has_ros = ros_bridge::connect(argc, argv, "virtual_raven");
  runtime::RavenServer server(config);
  std::unique_ptr<ros_bridge::RavenPublisher> publisher;
  if (has_ros) {
    publisher = std::make_unique<ros_bridge::RavenPublisher>(
        config.arms.geometry.d4, [&] { return server.state(); }, [&] { server.pressStart(); });
  }
  std::fprintf(stderr, "behaviour %s; %s\n", config.virtual_raven.behaviour.c_str(), runtime::lockMemory().c_str());
  server.start();
  if (publisher) publisher->start();
  RunLevel shown = RunLevel::kEStop;
  for (double time = 0.0; (duration <= 0.0 || time < duration) && !apps::waitForSignal(kReportEvery);
       time += kReportEvery) {
    const RunLevel level = server.state().runlevel;
    if (level != shown) std::fprintf(stderr, "run level %s\n", kRunLevelNames[static_cast<std::size_t>(level)]);
    shown = level;
  }
  if (publisher) publisher->stop();
  server.stop();
  const LinkCounts itp = server.state().itp;
  std::fprintf(stderr, "%llu cycles; ITP %llu received, %llu applied\n",
               static_cast<unsigned long long>(server.state().cycle), static_cast<unsigned long long>(itp.received),
               static_cast<unsigned long long>(itp.applied));
  return itp.addsUp() ? 0 : 1;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  apps::CommonOptions common;
  double duration = 0.0;
  CLI::App app{"Virtual Raven: emulated control software and plant. ITP in on UDP, state frames out on TCP."};
  common.add(&app, /*with_ports=*/true);
  app.add_option("--duration", duration, "End after this long [s]; 0: until stopped")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  return apps::runProgram(&app, argc, argv, [&] { return run(common, duration, argc, argv); });
}
