#include "raven2_trainer/studies/ompl_log.h"

#include <algorithm>

#include "raven2_trainer/studies/plan_tables.h"
#include "studies/number.h"

namespace raven2_trainer::studies {
namespace {

constexpr const char* kFormat = "1.5.2";  // the release of OMPL that writes its logs so

/** In alphabetical order, as OMPL has them; the values of a run in the same. */
constexpr const char* kProperties =
    "clearance REAL\ncorrect_solution BOOLEAN\ngraph_states INTEGER\nseed INTEGER\nsolution_cost REAL\nsolved BOOLEAN\n"
    "status ENUM\ntime REAL\ntracking_error REAL\nwaypoints INTEGER\n";
constexpr int kPropertyCount = 10;

/** Empty without a path. */
std::string lineOf(const PlanRun& run) {
  const PlanResult& plan = run.result;
  const bool has_path = plan.status == PlanStatus::kSuccess;
  const auto ofPath = [&](const std::string& value) { return has_path ? value : std::string(); };
  const auto status = std::min(static_cast<std::size_t>(plan.status), kPlanStatusCount - 1);
  const std::string cells[] = {ofPath(number(plan.clearance)),
                               isSuccess(run) ? "1" : "0",
                               std::to_string(plan.samples),
                               std::to_string(run.seed),
                               ofPath(number(plan.cost)),
                               has_path ? "1" : "0",
                               std::to_string(status),
                               number(plan.planning_time),
                               ofPath(number(plan.tracking_error)),
                               ofPath(std::to_string(plan.waypoint_count))};
  std::string line;
  for (const std::string& cell : cells)
    line += cell + "; ";
  return line + "\n";
}

/** pathName() without its run. */
std::string nameOf(const planning::PlanOptions& options) {
  const std::string name = pathName(options, 0);
  return name.substr(0, name.rfind("_r"));
}

std::string settingsOf(const planning::PlanOptions& o) {
  return "6 common properties\neta_acceleration = " + number(o.eta_acceleration) +
         "\neta_clearance = " + number(o.eta_clearance) + "\neta_length = " + number(o.eta_length) +
         "\nimprove_attempts = " + std::to_string(o.improve_attempts) +
         "\nmax_samples = " + std::to_string(o.max_samples) + "\nsamples = " + std::to_string(o.samples) + "\n";
}

std::string longestTime(const PlanStudyOptions& options) {
  double longest = 0.0;
  for (const planning::PlanOptions& o : options.cases)
    longest = std::max(longest, o.time_limit);
  return number(longest);
}

std::string head(const OmplExperiment& experiment, const PlanStudyOptions& options) {
  std::string text =
      std::string("OMPL version ") + kFormat + "\nExperiment " + experiment.name + "\n0 experiment properties\n";
  text += "Running on " + experiment.host + "\nStarting at " + experiment.started_utc + "\n";
  text += "<<<|\n" + experiment.description + "\n|>>>\n<<<|\nnot told\n|>>>\n";
  text += std::to_string(options.seed) + " is the random seed\n" + longestTime(options) + " seconds per run\n";
  text += "0 MB per run\n" + std::to_string(options.runs) + " runs per planner\n";
  text += number(experiment.seconds) + " seconds spent to collect the data\n1 enum type\nstatus";
  for (const char* name : kPlanStatusNames)
    text += std::string("|") + name;
  return text + "\n" + std::to_string(options.cases.size()) + " planners\n";
}

}  // namespace

std::string omplLog(const OmplExperiment& experiment,
                    const PlanStudyOptions& options,
                    const std::vector<PlanRun>& runs) {
  std::string text = head(experiment, options);
  for (std::size_t i = 0; i < options.cases.size(); ++i) {
    std::string lines;
    int count = 0;
    for (const PlanRun& run : runs) {
      if (run.case_index != i) continue;
      lines += lineOf(run);
      ++count;
    }
    text += nameOf(options.cases[i]) + "\n" + settingsOf(options.cases[i]);
    text += std::to_string(kPropertyCount) + " properties for each run\n" + kProperties;
    text += std::to_string(count) + " runs\n" + lines + ".\n";
  }
  return text;
}

}  // namespace raven2_trainer::studies
