// Plans one problem again and again and tracks each path on the model: the paper's Table 2, Figures 7 and 8, and the
// comparison of planners.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/run_script.h"
#include "apps/common/study_bar.h"
#include "raven2_trainer/config/load_problem.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/studies/ompl_log.h"
#include "raven2_trainer/studies/plan_files.h"
#include "raven2_trainer/studies/plan_study.h"
#include "raven2_trainer/studies/plan_tables.h"

namespace raven2_trainer {
namespace {

struct Options {
  apps::CommonOptions common;
  studies::PlanChoice choice;
  std::string problem{"paper"}, output, ompl_log;
  int runs{20}, threads{1};
  bool plot{false};
};

using Cases = std::vector<planning::PlanOptions>;

std::string utc(const char* format) {
  char text[32];
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  std::strftime(text, sizeof(text), format, gmtime_r(&now, &parts));
  return text;
}

std::string newFolder(const std::string& problem) {
  return "plans/" + problem + "_" + utc("%Y-%m-%dT%H-%M-%SZ");
}

void check(const Options& options) {
  // OMPL draws from one generator a process: side by side its planners would neither repeat nor be fair.
  for (const std::string& planner : options.choice.planners) {
    if (planner != "FMTstar" && options.threads > 1)
      throw ConfigException("--threads is " + std::to_string(options.threads) + ", expected 1 with --planner " +
                            planner);
  }
}

/** Runs and writes; the tracks themselves are only in the files. */
std::vector<studies::PlanRun> study(const TrainerConfig& config,
                                    const PlanProblem& problem,
                                    const studies::PlanStudyOptions& options,
                                    const std::string& label,
                                    studies::PlanFiles* files) {
  apps::StudyBar bar(label);
  std::vector<studies::PlanRun> runs;
  const auto all = static_cast<double>(options.cases.size()) * options.runs;
  studies::runPlanStudy(config, problem, options, [&](studies::PlanRun run) {
    files->add(options.cases[run.case_index], run);
    run.track.samples = {};
    runs.push_back(std::move(run));
    bar.update(static_cast<double>(runs.size()) / all);
  });
  files->close();
  bar.done(std::to_string(runs.size()) + " plans, " + files->directory());
  return runs;
}

/** The table and, with several planners or times, the comparison: on the terminal and as CSV. */
void report(const std::string& directory,
            const Cases& cases,
            const std::vector<studies::PlanRun>& runs,
            bool over_time) {
  const std::vector<studies::PlanTableRow> rows = studies::tableRows(cases, runs);
  std::string csv = over_time ? studies::comparisonHeader() : studies::tableHeader();
  for (const studies::PlanTableRow& row : rows)
    csv += over_time ? studies::comparisonLine(row) : studies::tableLine(row);
  studies::writeFile(directory + (over_time ? "/comparison.csv" : "/table.csv"), csv);
  std::printf("%s", (over_time ? comparisonText(rows) : tableText(rows)).c_str());
  const std::string reasons = studies::reasonsText(runs);
  if (!reasons.empty()) std::printf("without success: %s\n", reasons.c_str());
}

/** Adds the runs of Figure 7: two paths, and a straight motion in place of the user's. */
void addFigureRuns(const TrainerConfig& config,
                   const PlanProblem& problem,
                   studies::PlanStudyOptions options,
                   const std::string& directory,
                   const studies::PlanChoice& choice) {
  options.cases = figureCases(config.planner, choice);
  options.runs = 1;
  studies::PlanFiles files(directory, "figure7.csv");
  for (const studies::PlanRun& run : study(config, problem, options, "figure 7", &files)) {
    if (run.result.status != PlanStatus::kSuccess) continue;
    const loop::TrackedPath straight = loop::straightMotion(model::loadRavenModel(config), config.planner, run.result);
    studies::writeFile(directory + "/paths/straight.csv", studies::trackCsv(straight));
    break;
  }
}

studies::OmplExperiment experimentOf(const PlanProblem& problem) {
  char host[256] = "UNKNOWN";
  gethostname(host, sizeof(host) - 1);
  return {problem.name, problem.description, host, utc("%Y-%m-%d %H:%M:%S"), 0.0};
}

int plan(Options options) {
  check(options);
  const TrainerConfig config = options.common.load();
  const PlanProblem problem =
      config::findProblem(config::shareFolder() + "/config/problems", options.problem, config.arms.geometry);
  const bool over_time = !options.choice.times.empty();
  studies::PlanStudyOptions study_options;
  study_options.cases =
      over_time ? comparisonCases(config.planner, options.choice) : tableCases(config.planner, options.choice);
  study_options.runs = options.runs;
  study_options.seed = config.seed;
  study_options.threads = options.threads;
  studies::PlanFiles files(options.output.empty() ? newFolder(problem.name) : options.output, "runs.csv");
  std::printf("%s: %s\n", problem.name.c_str(), problem.description.c_str());
  if (options.threads > 1)
    std::printf("%d plans side by side: planning times are longer than alone\n", options.threads);
  studies::OmplExperiment experiment = experimentOf(problem);
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<studies::PlanRun> runs = study(config, problem, study_options, "plan", &files);
  experiment.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report(files.directory(), study_options.cases, runs, over_time);
  if (!options.ompl_log.empty())
    studies::writeFile(options.ompl_log, studies::omplLog(experiment, study_options, runs));
  std::fflush(stdout);  // ahead of what the script prints
  if (!options.plot) return 0;
  addFigureRuns(config, problem, study_options, files.directory(), options.choice);
  return apps::runScript("plot_paths", {files.directory(), "--scene", config.scene_urdf});
}

void addChoice(CLI::App* app, studies::PlanChoice* choice) {
  apps::within(app->add_option("--samples", choice->samples, "Number of collision-free samples")->delimiter(','), 10, 100000);
  app->add_option(
         "--eta", choice->eta,
         "Weights eta1,eta2[,eta3] of length, acceleration and clearance (default: the configuration's, without and "
         "with eta3)")
      ->delimiter(',')
      ->expected(2, 3)
      ->check(CLI::Range(0.0, 1e6));
  const std::vector<std::string> names(planning::kPlannerNames.begin(), planning::kPlannerNames.end());
  app->add_option("--planner", choice->planners, "Planner: FMTstar is our own, the others are OMPL's")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::IsMember(names));
  app->add_option("--times", choice->times, "Compare success and cost after these times [s], instead of the table")
      ->delimiter(',')
      ->check(CLI::Range(0.01, 3600.0));
  app->add_option("--time-limit", choice->time_limit, "Longest time for one plan [s] (default: the configuration's)")
      ->check(CLI::Range(0.01, 3600.0));
  app->add_option("--improve", choice->improve_attempts,
                  "Attempts to improve a path locally; 0: plain FMT* (default: the configuration's)")
      ->check(CLI::Range(0, 100000));
  app->add_flag("--exact", choice->is_exact, "Do not add samples after a failure");
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Plans a path several times, makes the model follow each path, and writes a table of the results."};
  app.footer(
      "Writes runs.csv, table.csv (with --times comparison.csv) and all paths to --output (doc/planning.md).\n"
      "Options that take lists: 200,500,1000. Exit status: 0 the tables are written, else failed.");
  app.add_option("problem", options.problem, "Problem: a name of config/problems, or FILE.yaml")->capture_default_str();
  app.add_option("--runs", options.runs, "Plans of each case, each with the next seed")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  addChoice(&app, &options.choice);
  apps::within(app.add_option("--threads", options.threads, "Plans at the same time, of FMTstar only"), 1, 64);
  app.add_option("--output", options.output, "Folder to create (default: plans/<problem>_<UTC stamp>)")
      ->type_name("DIR");
  app.add_option("--ompl-log", options.ompl_log,
                 "File to write: OMPL's benchmark log, for ompl_benchmark_statistics.py")
      ->type_name("FILE");
  app.add_flag("--plot", options.plot, "Draw Figures 7 and 8 of Li et al. 2017 in --output");
  app.add_option("--config", options.common.config,
                 "Root configuration file (default: the packaged config/trainer.yaml)")
      ->type_name("FILE");
  app.add_option("--seed", options.common.seed, "Seed of the first run (default: the configuration's)")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 53));
  return apps::runProgram(&app, argc, argv, [&] { return plan(options); });
}
