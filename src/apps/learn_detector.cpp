// Learns the detector's model and thresholds from fault-free runs in lockstep, and writes config/detector.yaml.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/study_bar.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/session/text_file.h"
#include "raven2_trainer/studies/detector_study.h"

namespace raven2_trainer {
namespace {

struct Options {
  apps::CommonOptions common;
  studies::LearnOptions learn;
  std::string output{"detector.yaml"};
};

std::string sourceOf(const TrainerConfig& config, const studies::LearnOptions& options) {
  char text[200];
  std::snprintf(text, sizeof(text),
                "learn_detector --runs %lld --seed %llu --ticks %lld --percentile %g --plant %s, motion scale %g",
                static_cast<long long>(options.runs), static_cast<unsigned long long>(options.seed),
                static_cast<long long>(options.ticks), options.percentile, config.virtual_raven.plant_name.c_str(),
                config.console.scale);
  return text;
}

int learn(Options options) {
  const TrainerConfig config = options.common.load();
  options.learn.seed = config.seed;
  physics::initialiseOde();
  physics::attachOdeToThread();
  apps::StudyBar bar("learn_detector");
  const studies::Learned learned =
      studies::learnDetector(config, options.learn, [&](double share) { bar.update(share); });
  session::TextWriter file(options.output);
  file.write(studies::detectorYaml(learned, sourceOf(config, options.learn)));
  file.close();
  bar.done(std::to_string(learned.runs) + " runs, " + std::to_string(learned.samples) + " ms, " + options.output);
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Learns the detector's model and thresholds from fault-free simulated sessions."};
  options.common.add(&app, /*with_ports=*/false);
  apps::CommonOptions::ignore(&app, {"--hazard", "--drill", "--trainee", "--curriculum"});
  apps::within(app.add_option("--runs", options.learn.runs, "Fault-free sessions, each with another seed"), 1, 100000);
  apps::within(app.add_option("--ticks", options.learn.ticks, "Length of each session from the first pedal-down [ms]"), 500,
               100000);
  apps::within(app.add_option("--percentile", options.learn.percentile, "Percentile of the fault-free values that becomes the threshold"), 50.0, 99.9999);
  app.add_option("--output", options.output, "File to write, in the format of config/detector.yaml")
      ->type_name("FILE")
      ->capture_default_str();
  return apps::runProgram(&app, argc, argv, [&] { return learn(options); });
}
