// merge_truth DIR FILE: the faults that the library at a real robot's USB boundary injected, brought into a session.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/common/command_line.h"
#include "raven2_trainer/recording/merge_truth.h"

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  CLI::App app{
      "Brings the ground truth of the library at a real robot's USB boundary into a session: its hazards are then "
      "reported and scored like those of the virtual Raven.",
      "merge_truth"};
  app.footer(
      "Writes DIR/usb_truth.json and makes metrics.json, faults.json and, with an exercise, score.json anew; the log "
      "stays\n"
      "as it is. Moments are found by the clock of the robot's computer or by the commands that the robot had taken.\n"
      "A session whose simulator runs with RAVEN2_USB_FAULTS_TRUTH set remembers the file; then FILE may be left out.\n"
      "doc/usb_faults.md. Exit status: 0 merged, 1 otherwise.");
  std::string directory, file;
  app.add_option("DIR", directory, "Session directory: the one that holds session.rlog")->required();
  app.add_option("FILE", file, "What RAVEN2_USB_FAULTS_TRUTH named (default: what it was for the simulator)");
  return apps::runProgram(&app, argc, argv, [&] {
    const training::TruthMerge merged = recording::mergeTruth(directory, file);
    std::printf("%zu injections act in the session, %zu lie outside; found by the %s\n", merged.inside, merged.outside,
                merged.by_clock ? "clock of the robot's computer" : "commands that the robot had taken");
    return 0;
  });
}
