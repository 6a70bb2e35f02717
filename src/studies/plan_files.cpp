#include "raven2_trainer/studies/plan_files.h"

#include <filesystem>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/studies/plan_tables.h"

namespace raven2_trainer::studies {
namespace {

namespace fs = std::filesystem;

/** Path of a file in a new study's folder, which is made. */
std::string newFile(const std::string& directory, const std::string& name) {
  const fs::path path = fs::path(directory) / name;
  std::error_code error;
  fs::create_directories(fs::path(directory) / "paths", error);
  if (error) throw SessionException(directory + ": cannot be created: " + error.message());
  if (fs::exists(path)) throw SessionException(path.string() + " exists already: every study needs a new folder");
  return path.string();
}

}  // namespace

void writeFile(const std::string& path, const std::string& text) {
  session::TextWriter file(path);
  file.write(text);
  file.close();
}

PlanFiles::PlanFiles(const std::string& directory, const std::string& runs_file)
    : directory_(directory), runs_(newFile(directory, runs_file)) {
  runs_.write(runsHeader());
}

void PlanFiles::add(const planning::PlanOptions& options, const PlanRun& run) {
  runs_.write(runsLine(options, run));
  if (run.result.status != PlanStatus::kSuccess) return;
  const std::string stem = directory_ + "/paths/" + pathName(options, run.run);
  writeFile(stem + ".csv", trackCsv(run.track));
  writeFile(stem + "_waypoints.csv", waypointsCsv(run.result));
}

}  // namespace raven2_trainer::studies
