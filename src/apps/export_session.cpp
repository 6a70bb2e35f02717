// export_session DIR: the session log as what other programs read.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/run_script.h"
#include "apps/common/session_config.h"
#include "apps/export/session_bag.h"
#include "raven2_trainer/session/csv_export.h"
#include "raven2_trainer/session/session_directory.h"

namespace {

using raven2_trainer::session::SessionPaths;

/** scripts/export_dataset writes it. */
int exportJigsaws(const std::string& directory, const std::string& output) {
  std::vector<std::string> words;
  if (!output.empty()) words.push_back("--output=" + output);
  words.insert(words.end(), {"--", directory});
  return raven2_trainer::apps::runScript("export_dataset", words);
}

int exportTicks(const SessionPaths& paths, const std::string& output) {
  const std::string csv = output.empty() ? paths.ticks() : output;
  raven2_trainer::apps::ProgressBar bar("export");
  const auto progress = [&bar](double share) { bar.update(share); };
  const std::size_t rows = raven2_trainer::session::exportTicksCsv(paths.log(), csv, progress);
  bar.done(csv + ": " + std::to_string(rows) + " rows");
  return 0;
}

int exportBag(const SessionPaths& paths, const std::string& output) {
  using namespace raven2_trainer;
  const std::string path = output.empty() ? paths.directory + "/session.bag" : output;
  apps::ProgressBar bar("export");
  const auto progress = [&bar](double share) { bar.update(share); };
  const apps::BagCounts counts = apps::writeSessionBag(apps::viewingConfig(paths, ""), paths, path, progress);
  bar.done(path + ": " + std::to_string(counts.messages) + " messages of " + std::to_string(counts.topics) + " topics");
  return 0;
}

int exportSession(const std::string& directory, const std::string& format, const std::string& output) {
  const SessionPaths paths = raven2_trainer::session::openSessionDirectory(directory);
  if (format == "jigsaws") return exportJigsaws(directory, output);
  return format == "csv" ? exportTicks(paths, output) : exportBag(paths, output);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Exports a recorded session as a CSV table, as JIGSAWS kinematics or as a ROS bag.",
      "export_session"};
  app.footer(
      "csv: one row per millisecond and arm, in SI units; ticks count from the first pedal-down:\n"
      "  tick, t_s, arm, mode, runlevel, pedal\n"
      "  q1..q7, dq1..dq7, tau1..tau7   model: joint position, velocity, torque\n"
      "  rq1..rq7, rdq1..rdq7           robot: joint position, velocity\n"
      "  px..pz, rpx..rpz               tool tip of model and robot in the arm's base frame\n"
      "  fx..fz, fault                  force cue; fault scenario acting on the robot\n"
      "jigsaws: 30 Hz, 76 columns, and the exercise's steps in FILE_labels.txt. rosbag: the simulator's topics.\n"
      "More: doc/session.md, doc/report.md. Exit status: 0 written, 1 otherwise.");
  std::string directory;
  std::string format = "csv";
  std::string output;
  app.add_option("DIR", directory, "Session directory, with session.rlog")->required();
  app.add_option("--format", format, "Format of the file")
      ->check(CLI::IsMember({"csv", "jigsaws", "rosbag"}))
      ->capture_default_str();
  app.add_option("--output", output, "File to write (default: DIR/ticks.csv, jigsaws.txt, session.bag)");
  return raven2_trainer::apps::runProgram(&app, argc, argv, [&] { return exportSession(directory, format, output); });
}
