// export_session DIR...: sessions in the formats of other programs.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/run_script.h"
#include "apps/common/session_config.h"
#include "apps/export/session_bag.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/csv_export.h"
#include "raven2_trainer/session/session_directory.h"

namespace {

using raven2_trainer::session::SessionPaths;

struct Options {
  std::vector<std::string> directories;
  std::string format{"csv"}, output, cameras, size{"320x240"}, lerobot{"3.0"};
  int fps{30}, jobs{0};
};

bool isLearningFormat(const std::string& format) {
  return format == "hdf5" || format == "lerobot";
}

/** scripts/export_dataset writes it. */
int exportByScript(const Options& options) {
  std::vector<std::string> words{"--format=" + options.format};
  if (!options.output.empty()) words.push_back("--output=" + options.output);
  if (isLearningFormat(options.format)) {
    words.insert(words.end(), {"--cameras=" + options.cameras, "--size=" + options.size, "--lerobot=" + options.lerobot,
                               "--fps=" + std::to_string(options.fps)});
    if (options.jobs != 0) words.push_back("--jobs=" + std::to_string(options.jobs));
  }
  words.emplace_back("--");
  words.insert(words.end(), options.directories.begin(), options.directories.end());
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

int exportSessions(const Options& options) {
  std::vector<SessionPaths> paths;
  for (const std::string& directory : options.directories)
    paths.push_back(raven2_trainer::session::openSessionDirectory(directory));
  if (isLearningFormat(options.format)) return exportByScript(options);
  if (paths.size() != 1) {
    throw raven2_trainer::ConfigException(std::to_string(paths.size()) + " sessions for the format " + options.format +
                                          ", which takes one");
  }
  if (options.format == "jigsaws") return exportByScript(options);
  return options.format == "csv" ? exportTicks(paths.front(), options.output)
                                 : exportBag(paths.front(), options.output);
}

void addLearningOptions(CLI::App* app, Options* options) {
  app->add_option("--cameras", options->cameras,
                  "hdf5, lerobot: cameras A,B of config/render.yaml (default: no pictures)");
  app->add_option("--size", options->size, "hdf5, lerobot: size of the pictures, WIDTHxHEIGHT")
      ->type_name("WxH")
      ->capture_default_str();
  app->add_option("--fps", options->fps, "hdf5, lerobot: frames per second")
      ->check(CLI::Range(1, 120))
      ->capture_default_str();
  app->add_option("--lerobot", options->lerobot, "lerobot: version of the format")
      ->check(CLI::IsMember({"2.1", "3.0"}))
      ->capture_default_str();
  app->add_option("--jobs", options->jobs, "hdf5, lerobot: sessions at the same time; 0: one for each processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Exports a recorded session as a CSV table, as JIGSAWS kinematics or as a ROS bag, or many sessions as one data "
      "set.",
      "export_session"};
  app.footer(
      "csv: one row per millisecond and arm, in SI units; ticks count from the first pedal-down:\n"
      "  tick, t_s, arm, mode, runlevel, pedal\n"
      "  q1..q7, dq1..dq7, tau1..tau7   model: joint position, velocity, torque\n"
      "  rq1..rq7, rdq1..rdq7           robot: joint position, velocity\n"
      "  px..pz, rpx..rpz               tool tip of model and robot in the arm's base frame\n"
      "  fx..fz, fault                  force cue; name of the acting hazard\n"
      "jigsaws: 30 Hz, 76 columns, and the exercise's steps in NAME_labels.txt. rosbag: the simulator's topics.\n"
      "hdf5, lerobot: one data set of all DIRs, with the truth about the hazards (doc/python.md).\n"
      "More: doc/session.md, doc/report.md. Exit status: 0 written, else failed.");
  Options options;
  app.add_option("DIR", options.directories, "Session directories, each with session.rlog")->required();
  app.add_option("--format", options.format, "Format of the file")
      ->check(CLI::IsMember({"csv", "jigsaws", "rosbag", "hdf5", "lerobot"}))
      ->capture_default_str();
  app.add_option("--output", options.output,
                 "File to write (default: DIR/ticks.csv, DIR/jigsaws.txt, DIR/session.bag, ./dataset.hdf5, or the "
                 "folder ./dataset)")
      ->type_name("FILE");
  addLearningOptions(&app, &options);
  return raven2_trainer::apps::runProgram(&app, argc, argv, [&] { return exportSessions(options); });
}
