// The virtual Raven's plant against a recording of a real arm: predicts motor positions from recorded states and
// recorded DAC, open loop. scripts/identify_plant fits the plant's parameters with it.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/plant/motor_replay.h"

namespace raven2_trainer {
namespace {

constexpr double kDegree = kPi / 180.0;

struct Options {
  apps::CommonOptions common;
  std::string recording;
  std::string output;
  double from{2.0 / 3.0};
  double to{1.0};
  std::size_t stride{5};
  std::vector<std::size_t> horizons{100};
};

/** One line: errors of the plant and of going on with the recorded rate. */
void writeRow(std::ofstream* file,
              const plant::MotorRecording& recording,
              std::size_t row,
              std::size_t horizon,
              const plant::MotorReplay::Motors& predicted) {
  const auto& truth = recording.rows[row + horizon].position;
  const auto& start = recording.rows[row];
  *file << row << ',' << horizon;
  for (std::size_t i = 0; i < 3; ++i)
    *file << ',' << (predicted[i] - truth[i]) / kDegree;
  for (std::size_t i = 0; i < 3; ++i) {
    const double straight = start.position[i] + start.rate[i] * static_cast<double>(horizon) * kTickSeconds;
    *file << ',' << (straight - truth[i]) / kDegree;
  }
  *file << '\n';
}

void printSummary(plant::MotorReplay* replay, const Options& options, std::size_t first, std::size_t last) {
  const std::size_t horizon = options.horizons.back();
  const plant::ReplayError error = plant::replayError(replay, first, last, options.stride, horizon);
  std::printf("axis, rms error of the motor %zu ms ahead [deg]: plant, constant velocity, ratio\n", horizon);
  for (std::size_t i = 0; i < 3; ++i) {
    std::printf("%s %.3f %.3f %.3f\n", kJointNames[i], error.plant[i] / kDegree, error.constant_velocity[i] / kDegree,
                error.plant[i] / error.constant_velocity[i]);
  }
}

void writeErrors(plant::MotorReplay* replay, const Options& options, std::size_t first, std::size_t last) {
  std::ofstream file(options.output);
  if (!file) throw ConfigException(options.output + ": cannot be written");
  file << "row,horizon_ms,error1_deg,error2_deg,error3_deg,straight1_deg,straight2_deg,straight3_deg\n";
  const std::size_t longest = options.horizons.back();
  for (std::size_t row = first; row < last; row += options.stride) {
    replay->leadTo(row);
    const auto path = replay->predict(longest);
    for (const std::size_t horizon : options.horizons)
      writeRow(&file, replay->recording(), row, horizon, path[horizon - 1]);
  }
  if (!file.flush()) throw ConfigException(options.output + ": cannot be written");
}

int replayAll(Options options) {
  std::sort(options.horizons.begin(), options.horizons.end());
  const TrainerConfig config = options.common.load();
  plant::MotorReplay replay(model::loadRavenModel(config), config.virtual_raven,
                            plant::loadMotorRecording(options.recording));
  const std::size_t rows = replay.recording().rows.size();
  const std::size_t usable = rows - std::min(rows, options.horizons.back());
  const auto share = [&](double part) { return static_cast<std::size_t>(part * static_cast<double>(rows)); };
  const std::size_t first = share(options.from), last = std::min(share(options.to), usable);
  if (first >= last) throw ConfigException("--from, --to and --horizons leave no row to start from");
  if (options.output.empty()) {
    printSummary(&replay, options, first, last);
  } else {
    writeErrors(&replay, options, first, last);
  }
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Drives the virtual Raven's plant with a real robot's recorded DAC commands and compares the motion."};
  options.common.add(&app, /*with_ports=*/false);
  apps::CommonOptions::ignore(
      &app, {"--exercise", "--hazard", "--drill", "--trainee", "--curriculum", "--seed", "--arm-contacts"});
  app.add_option("recording", options.recording, "Gold arm's CSV, 1 kHz: mpos1_deg .. mpos3_deg, dac1 .. dac3 [counts]")
      ->required();
  apps::within(app.add_option("--from", options.from, "First start, as a share of the recording"), 0.0, 1.0);
  apps::within(app.add_option("--to", options.to, "Last start, as a share of the recording"), 0.0, 1.0);
  apps::within(app.add_option("--stride", options.stride, "Rows between starts"), 1, 100000);
  apps::within(app.add_option("--horizons", options.horizons, "Times ahead A,B [ms]; the summary has the longest")
                   ->delimiter(','),
               1, 10000);
  app.add_option("--output", options.output, "CSV file for each error, instead of the summary")->type_name("FILE");
  return apps::runProgram(&app, argc, argv, [&] { return replayAll(options); });
}
