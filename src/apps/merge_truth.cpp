// merge_truth DIR FILE: the faults that the library at a real robot's USB boundary injected, brought into a session.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "apps/common/command_line.h"
#include "raven2_trainer/recording/merge_truth.h"

namespace {

/** A band that was given to score_session may be gone by now. The merge stays. */
int renewScore(const std::string& directory) {
  try {
    raven2_trainer::recording::scoreMerged(directory);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\nmerged, but score.json does not know it yet: score_session %s --band FILE\n", e.what(),
                 directory.c_str());
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  CLI::App app{
      "Adds the faults that libraven2_usb_faults.so injected into a real robot to a session's metrics and scores.",
      "merge_truth"};
  app.footer(
      "Writes DIR/usb_truth.json, and metrics.json, faults.json and, with an exercise, score.json again. The log does\n"
      "not change. Times come from the clock of the robot's computer, or from the commands that the robot received.\n"
      "FILE may be omitted if the simulator ran with RAVEN2_USB_FAULTS_TRUTH set.\n"
      "doc/usb_faults.md. Exit status: 0 merged and scored, else failed.");
  std::string directory, file;
  app.add_option("DIR", directory, "Session directory, with session.rlog")->required();
  app.add_option("FILE", file, "File that RAVEN2_USB_FAULTS_TRUTH named (default: the one that the simulator had)");
  return apps::runProgram(&app, argc, argv, [&] {
    const training::TruthMerge merged = recording::mergeTruth(directory, file);
    std::printf("%zu injections act in the session, %zu lie outside; found by the %s\n", merged.inside, merged.outside,
                merged.by_clock ? "clock of the robot's computer" : "commands that the robot had taken");
    return renewScore(directory);
  });
}
