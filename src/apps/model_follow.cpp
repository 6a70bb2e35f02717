// model_follow: the nominal model under its own controller follows desired joint positions; no robot, no contacts.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/csv_table.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/loop/model_driver.h"

namespace raven2_trainer {
namespace {

struct Options {
  std::string config, arm{"gold"}, desired, out;
};

std::vector<std::string> numbered(const std::string& stem, const std::string& suffix = "") {
  std::vector<std::string> names;
  for (std::size_t j = 1; j <= kJointCount; ++j)
    names.push_back(stem + std::to_string(j) + suffix);
  return names;
}

std::vector<std::string> outputColumns() {
  std::vector<std::string> columns;
  for (const char* quantity : {"q", "dq", "tau"}) {
    for (const std::string& name : numbered(quantity))
      columns.push_back(name);
  }
  return columns;
}

/** Starts at rest on the first row; row k of the result is what a robot would measure when row k is commanded. */
void follow(const TrainerConfig& config,
            Arm arm,
            const std::vector<std::vector<double>>& desired,
            apps::CsvWriter* out) {
  const model::RavenModel raven = model::loadRavenModel(config);
  physics::RavenWorld world(raven, model::loadSceneModel(config), config.model);
  loop::ModelDriver driver(config.model, config.arms.geometry, &world);
  PerArm<JointArray> q_d{config.arms.geometry.home, config.arms.geometry.home};
  apps::ProgressBar bar("model_follow");
  for (std::size_t row = 0; row < desired.size(); ++row) {
    std::copy_n(desired[row].begin(), kJointCount, at(q_d, arm).begin());
    for (const Arm each : kArms) {
      world.setCollisions(each, false);
      if (row == 0) world.setJointState(each, at(q_d, each), JointArray{});
    }
    JointArray q{}, dq{};
    world.jointState(arm, &q, &dq);
    const PerArm<JointArray> tau = driver.step(q_d);
    if (!world.healthy()) throw ModelException("the model came to a stop at row " + std::to_string(row + 1));
    for (const JointArray& values : {q, dq, at(tau, arm)}) {
      for (const double value : values)
        out->cell(value);
    }
    out->endRow();
    bar.update(static_cast<double>(row + 1) / static_cast<double>(desired.size()));
  }
  bar.done(std::to_string(desired.size()) + " rows");
}

/** Beyond this a value is in other units, or garbage. [rad, m] */
constexpr double kLargest = 10.0;

void checkDesired(const std::vector<std::vector<double>>& desired, const std::string& file) {
  for (std::size_t row = 0; row < desired.size(); ++row) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      if (std::abs(desired[row][j]) <= kLargest) continue;
      throw apps::CsvException(file + ":" + std::to_string(row + 2) + ": q" + std::to_string(j + 1) + "_d is " +
                               std::to_string(desired[row][j]) + ", allowed [-10, 10] (rad; m for q3_d)");
    }
  }
}

int run(const Options& options) {
  apps::CommonOptions common;
  common.config = options.config;
  const TrainerConfig config = common.load();
  const auto desired = apps::readTable(options.desired, numbered("q", "_d"));
  if (desired.empty()) throw apps::CsvException(options.desired + ": no rows below the header");
  checkDesired(desired, options.desired);
  physics::initialiseOde();
  physics::attachOdeToThread();
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(options.out.c_str(), "wb"), &std::fclose);
  if (!file) throw ConfigException(options.out + ": cannot be written");
  apps::CsvWriter out(file.get());
  out.header(outputColumns());
  follow(config, options.arm == "gold" ? Arm::kGold : Arm::kGreen, desired, &out);
  out.flush();
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  raven2_trainer::Options options;
  CLI::App app{"Makes the model of one arm follow a table of joint positions with its own controller, without contacts."};
  app.footer(
      "Tables are CSV, one row a millisecond; q1..q7 shoulder, elbow, insertion, tool rotation, wrist, two jaws, in\n"
      "the robot's coordinates [rad; insertion m]. In: q1_d..q7_d. Out: q1..q7, dq1..dq7 [rad/s; m/s] before the step\n"
      "that follows and tau1..tau7 [Nm; N] during it. The arm starts at rest on the first row; the other arm is at "
      "home.\n"
      "Exit status: 0 done, 1 failed, 2 wrong table, above 100 wrong arguments.");
  app.add_option("--arm", options.arm, "gold or green")->capture_default_str()->check(CLI::IsMember({"gold", "green"}));
  app.add_option("--desired", options.desired, "CSV file of desired positions")->type_name("FILE")->required();
  app.add_option("--out", options.out, "CSV file to write")->type_name("FILE")->required();
  app.add_option("--config", options.config, "Root configuration file (default: the packaged config/trainer.yaml)")
      ->type_name("FILE");
  return raven2_trainer::apps::runProgram(&app, argc, argv, [&] { return raven2_trainer::run(options); });
}
