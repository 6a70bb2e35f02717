// On a real Raven's computer: its /ravenstate as the state frames that the daemon reads from a virtual one.

#include <CLI/CLI.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/signals.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/ros/raven_state_bridge.h"
#include "raven2_trainer/ros/supervisor.h"

namespace raven2_trainer {
namespace {

constexpr double kLookEvery = 0.005;  // [s] a quarter of the daemon's limit for a stale state

/** Says when the topic stops and when it comes back. */
class StaleWatch {
 public:
  StaleWatch(const std::string& topic, double limit) : topic_(topic), limit_(limit) {}

  void look(std::int64_t newest_ns) {
    const double age = static_cast<double>(net::monotonicNow() - newest_ns) * 1e-9;
    const bool is_stale = newest_ns == 0 || age > limit_;
    if (is_stale && !is_stale_)
      std::fprintf(stderr, "%s: nothing for %.0f ms, the state is stale\n", topic_.c_str(), 1e3 * limit_);
    if (!is_stale && is_stale_) std::fprintf(stderr, "%s: states arrive\n", topic_.c_str());
    is_stale_ = is_stale;
  }

 private:
  std::string topic_;
  double limit_;
  bool is_stale_{true};
};

int run(const apps::CommonOptions& common,
        const std::string& address,
        const std::string& topic,
        int argc,
        char** argv) {
  TrainerConfig config = common.load();
  if (!address.empty()) config.network.bind_address = address;  // of the frames: no ITP is taken here
  robot::StateServer server(config.network.bind_address, config.network.state_port, /*is_virtual=*/false);
  ros_bridge::RavenStateBridge bridge(config.virtual_raven, topic, &server);
  ros_bridge::Supervisor ros(argc, argv, "raven_state_bridge", &bridge);
  server.start();
  ros.start();
  std::fprintf(stderr, "waiting for %s; state frames on TCP port %u\n", topic.c_str(), server.port());
  StaleWatch watch(topic, config.network.stale_after);
  while (!apps::waitForSignal(kLookEvery))
    watch.look(bridge.newest());
  ros.end();
  server.stop();
  const auto n = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
  std::fprintf(
      stderr,
      "%llu messages, %llu of them refused; %llu states lost on the way to the sender, %llu frames lost by slow "
      "readers; %llu fault plans refused\n",
      n(bridge.received()), n(bridge.refused()), n(server.statesDropped()), n(server.framesDropped()),
      n(server.plansRefused()));
  return ros.leave(0);
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  apps::CommonOptions common;
  std::string topic = "/ravenstate";
  CLI::App app{"Sends a real Raven's state to the trainer: ROS topic /ravenstate in, TCP out. Runs on the robot's computer."};
  common.add(&app, /*with_ports=*/true);
  apps::CommonOptions::ignore(
      &app, {"--exercise", "--hazard", "--drill", "--trainee", "--curriculum", "--seed", "--arm-contacts", "--plant",
             "--master-port", "--robot-port", "--force-port", "--sight-port"});
  std::string address;
  app.add_option("--bind-address", address,
                 "IPv4 address of this computer to listen on (default: the configuration's)")
      ->check(CLI::ValidIPV4);
  app.add_option("--topic", topic, "Topic of type raven_2/raven_state, as raven2 or raven2_sim publishes it")
      ->capture_default_str();
  return apps::runProgram(&app, argc, argv, [&] { return run(common, address, topic, argc, argv); });
}
