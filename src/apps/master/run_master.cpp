#include "apps/master/run_master.h"

#include <cstdio>

#include "apps/common/signals.h"
#include "raven2_trainer/config/load_master.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/console/device_surgeon.h"
#include "raven2_trainer/daemon/console_runner.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/ros/master_devices.h"
#include "raven2_trainer/ros/supervisor.h"

namespace raven2_trainer::apps {
namespace {

constexpr double kPoll = 0.05;     // [s]
constexpr double kPatience = 2.0;  // [s] without a ROS master until a warning

/** Prints what changed since the last look: troubles of devices, and when the surgeon engages and releases. */
class ReportPrinter {
 public:
  explicit ReportPrinter(const MasterConfig& config) : config_(config) {}

  void look(const MasterReport& report) {
    for (const Arm arm : kArms)
      printDevice(arm, report);
    printPedal(report);
    last_ = report;
  }

 private:
  /** Also prints a release between two looks. */
  void printPedal(const MasterReport& report) const {
    const bool is_new = report.engagements != last_.engagements;
    if (last_.engaged != 0 && (is_new || report.engaged == 0)) std::fputs("let go\n", stderr);
    if (is_new) std::fputs("engaged\n", stderr);
    if (is_new && report.engaged == 0) std::fputs("let go\n", stderr);
  }

  void printDevice(Arm arm, const MasterReport& report) {
    const DeviceFinding& newest = at(report.newest, arm);
    if (at(report.found, arm) != at(last_.found, arm)) {
      std::fprintf(stderr, "%s%s\n", words(config_, arm, newest).c_str(),
                   liftsPedal(newest.trouble) ? "; the pedal counts as up" : "");
    }
    const bool was_wrong = at(last_.now, arm).trouble != DeviceTrouble::kNone;
    if (was_wrong && at(report.now, arm).trouble == DeviceTrouble::kNone && at(report.found, arm) > 0)
      std::fprintf(stderr, "%s: in order again\n", deviceName(arm));
  }

  const MasterConfig& config_;
  MasterReport last_;
};

void print(ros_bridge::MasterDevices* devices) {
  std::string line;
  while (devices->nextLine(&line))
    std::fprintf(stderr, "%s\n", line.c_str());
}

PerArm<double> jawsAtHome(const TrainerConfig& config) {
  const double opening = kinematics::jawOpening(config.arms.geometry.home);
  return {opening, opening};
}

}  // namespace

int runMaster(TrainerConfig config, const MasterOptions& options, int argc, char** argv) {
  MasterConfig master = config::findMaster(config::shareFolder() + "/config/masters", options.master);
  if (options.scale > 0.0) master.scale = options.scale;
  const std::string of_scale = wordsOfScale(master, config.console.scale);
  if (!of_scale.empty()) std::fprintf(stderr, "%s\n", of_scale.c_str());
  config.console.scale = master.scale;
  config.network.sight = false;  // a person needs no sight packets
  MasterLink link;
  daemon::ConsoleRunner console(config, console::makeDeviceSurgeon(master, jawsAtHome(config), &link));
  ros_bridge::MasterDevices devices(master, &link);
  ros_bridge::Supervisor ros(argc, argv, "master_console", &devices);
  console.start();
  ros.start();
  std::fprintf(stderr, "master %s: scale %.3g\n", master.name.c_str(), config.console.scale);
  ReportPrinter printer(master);
  for (double time = 0.0; options.duration <= 0.0 || time < options.duration; time += kPoll) {
    if (waitForSignal(kPoll)) break;
    printer.look(link.report.load());
    print(&devices);
    if (time < kPatience && time + kPoll >= kPatience && !ros.met())
      std::fprintf(stderr, "no ROS master yet: the devices need one; waiting\n");
  }
  console.stop();
  ros.end();
  const LinkCounts forces = console.forceCounts();
  std::fprintf(stderr, "forces: %llu received = %llu applied + %llu rejected\n",
               static_cast<unsigned long long>(forces.received), static_cast<unsigned long long>(forces.applied),
               static_cast<unsigned long long>(forces.rejectedTotal()));
  const int status = ros.leave(0);
  print(&devices);
  return status;
}

}  // namespace raven2_trainer::apps
