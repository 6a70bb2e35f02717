// recover_session DIR: completes the log of a session whose process was killed.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "apps/common/command_line.h"
#include "raven2_trainer/recording/finish_session.h"
#include "raven2_trainer/recording/recover.h"
#include "raven2_trainer/session/recovery.h"

namespace {

int recover(const std::string& directory) {
  const raven2_trainer::session::SessionPaths paths{directory};
  if (!std::filesystem::is_regular_file(paths.log())) {
    std::fprintf(stderr, "%s: is no session directory (no session.rlog in it)\n", directory.c_str());
    return 1;
  }
  if (!raven2_trainer::session::isUnclean(paths) && !raven2_trainer::session::lacksMetrics(paths) &&
      !raven2_trainer::session::leavesFlightFile(paths) &&
      !raven2_trainer::recording::lacksScore(paths)) {
    std::fprintf(stderr, "%s: nothing to recover: it ended cleanly, or was recovered before\n", directory.c_str());
    return 0;
  }
  return raven2_trainer::recording::recoverAndReport(paths, {}) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Completes the files of a session whose simulator was killed.", "recover_session"};
  app.footer(
      "Cuts the log after its last complete record, appends what the flight recorder in /dev/shm still has, and "
      "writes\n"
      "recovered.json, metrics.json, faults.json and, with an exercise, score.json (doc/session.md). The simulator "
      "does\n"
      "the same at its start for up to 64 sessions next to its own.\n"
      "Exit status: 0 recovered or nothing to do, else failed.");
  std::string directory;
  app.add_option("DIR", directory, "Session directory, with session.rlog")->required();
  return raven2_trainer::apps::runProgram(&app, argc, argv, [&] { return recover(directory); });
}
