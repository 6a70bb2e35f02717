#include "apps/common/motion_options.h"

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

constexpr double kLongestReaction = 60000.0;  // [ms]

}  // namespace

void MotionOptions::add(CLI::App* app) {
  app->add_option(
         "--motion", motion,
         "Simulated surgeon: scripted, recording:FILE (CSV of tip positions); with --exercise expert or clumsy:NAME "
         "(doc/exercises.md); in simulate also commands:FILE (of a Python session)")
      ->capture_default_str();
  app->add_option("--reaction", reaction,
                  "Time from a force, or a visible gap between robot and model, to the pedal-up [ms]; none: the "
                  "simulated surgeon never reacts")
      ->type_name("MS")
      ->capture_default_str();
  app->add_option("--truth", truth, "CSV file: a row for each action of the simulated surgeon")->type_name("FILE");
}

console::MotionChoice MotionOptions::choice() const {
  console::MotionChoice result;
  result.motion = motion;
  if (reaction == "none") return result;
  char* end = nullptr;
  const double milliseconds = std::strtod(reaction.c_str(), &end);
  const bool is_number = end != reaction.c_str() && *end == '\0';
  if (!is_number || !(milliseconds >= 0.0 && milliseconds <= kLongestReaction))
    throw ConfigException("reaction is \"" + reaction + "\", expected none or 0 to 60000 ms");
  result.reaction = 1e-3 * milliseconds;
  return result;
}

TruthFile::TruthFile(const std::string& path) : path_(path) {
  if (path_.empty()) return;
  stream_.open(path_);
  if (!stream_) throw ConfigException("truth file " + path_ + " cannot be written");
}

void TruthFile::write() {
  if (path_.empty()) return;
  log_.write(stream_);
  stream_.close();
  if (!stream_) throw ConfigException("truth file " + path_ + " cannot be written");
}

}  // namespace raven2_trainer::apps
