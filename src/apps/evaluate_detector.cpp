// Evaluates the detector on the two grids of faults of DSN 2016 in lockstep: a row of CSV a run, and the rates.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/csv_table.h"
#include "apps/common/study_bar.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/studies/detector_study.h"

namespace raven2_trainer {
namespace {

using Scenario = studies::StudyFault::Scenario;

struct Options {
  apps::CommonOptions common;
  studies::EvaluateOptions evaluate;
  std::string output{"detector.csv"};
};

constexpr const char* kScenarioNames[] = {"inputs", "torque"};

const std::vector<std::string> kColumns{"scenario",       "seed",
                                        "kind",           "value",
                                        "length",         "unsafe",
                                        "decided_ms",     "harmed_ms",
                                        "stopped_ms",     "departure_m",
                                        "jump_2ms_m",     "published_alarm_ms",
                                        "published_size", "departure_alarm_ms",
                                        "departure_size"};

void writeRow(const studies::StudyOutcome& o, apps::CsvWriter* out) {
  out->cell(kScenarioNames[static_cast<int>(o.fault.scenario)]);
  out->cell(static_cast<double>(o.seed));
  out->cell(kFaultKindNames[static_cast<std::size_t>(o.fault.kind)]);
  out->cell(o.fault.value);
  for (const Tick tick : {o.fault.length, Tick{o.is_unsafe}, o.decided, o.harmed, o.stopped})
    out->cell(static_cast<double>(tick));
  out->cell(o.departure);
  out->cell(o.jump);
  for (const auto& rule : o.rules) {
    out->cell(static_cast<double>(rule.alarm));
    out->cell(rule.in_time);
  }
  out->endRow();
}

void printRates(const std::vector<studies::StudyOutcome>& outcomes, double factor) {
  for (const Scenario scenario : {Scenario::kInputs, Scenario::kTorque}) {
    for (std::size_t rule = 0; rule < kDetectorRuleNames.size(); ++rule) {
      const studies::StudyRates r = ratesOf(outcomes, scenario, static_cast<DetectorRule>(rule), factor);
      std::printf("%s, rule %s: true positives %d of %d (%.1f %%), false %d of %d (%.1f %%), stopped harmless %d\n",
                  kScenarioNames[static_cast<int>(scenario)], kDetectorRuleNames[rule], r.detected, r.unsafe,
                  100.0 * r.truePositive(), r.false_alarms, r.safe, 100.0 * r.falsePositive(), r.stopped);
    }
  }
}

int evaluate(Options options) {
  const TrainerConfig config = options.common.load();
  physics::initialiseOde();
  physics::attachOdeToThread();
  std::FILE* file = std::fopen(options.output.c_str(), "w");
  if (file == nullptr) throw SessionException(options.output + ": cannot be written");
  std::vector<studies::StudyOutcome> outcomes;
  {
    apps::CsvWriter csv(file);
    csv.header(kColumns);
    apps::StudyBar bar("evaluate_detector");
    const auto take = [&](const studies::StudyOutcome& outcome) {
      writeRow(outcome, &csv);
      outcomes.push_back(outcome);
    };
    studies::evaluateDetector(config, options.evaluate, take, [&](double share) { bar.update(share); });
    csv.flush();
    bar.done(std::to_string(outcomes.size()) + " runs, " + options.output);
  }
  std::fclose(file);
  printRates(outcomes, config.detector.factor);
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Measures how well the detector finds the faults of Alemzadeh et al. 2016 in simulated sessions."};
  options.common.add(&app, /*with_ports=*/false);
  apps::CommonOptions::ignore(&app, {"--hazard", "--drill", "--trainee", "--curriculum", "--seed"});
  studies::EvaluateOptions& e = options.evaluate;
  app.add_option("--first-seed", e.seed, "Seed of the first session; each further session uses the next seed")->capture_default_str();
  apps::within(app.add_option("--input-starts", e.input_starts, "Sessions; each is run with all 48 input faults"), 0,
               10000);
  apps::within(
      app.add_option("--torque-starts", e.torque_starts, "Sessions; each is run with one DAC value for 1, 2 ... 19 ms"),
      0, 10000);
  apps::within(app.add_option("--add-starts", e.add_starts, "Sessions; each is run with all 64 additions to DAC"), 0,
               10000);
  apps::within(
      app.add_option("--watched", e.watched, "Time after a fault's end in which a tip's departure counts [ms]"), 1,
      5000);
  apps::within(app.add_option("--unsafe", e.unsafe, "Distance of the tip from its fault-free path that counts as unsafe [m]"), 1e-5, 1.0);
  apps::within(app.add_option("--slack", e.slack, "Time for an alarm after harm was certain [ms]"), 0, 1000);
  app.add_option("--output", options.output, "CSV file to write, one row for each run")
      ->type_name("FILE")
      ->capture_default_str();
  return apps::runProgram(&app, argc, argv, [&] { return evaluate(options); });
}
