#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "raven2_trainer/studies/plan_study.h"

// Results of a study of the planner: CSV files and the paper's Table 2 as text. doc/planning.md describes the
// files.

namespace raven2_trainer::studies {

/** Values of many runs. NaN where there are too few. */
struct Summary {
  std::size_t count{};
  double mean{};
  double deviation{};  ///< of the sample: divided by count - 1
  double median{};     ///< the mean of the two in the middle of an even count
  double least{}, greatest{};
};

Summary summarise(std::vector<double> values);

/** All runs of one case. Planning times are those of all runs, what is said of paths is that of the successes. */
struct PlanTableRow {
  planning::PlanOptions options;
  int runs{};
  int successes{};
  int exact_successes{};   ///< without samples added after a failure; of planners that take n samples
  Summary planning_time;   ///< [s]
  Summary tracking_time;   ///< [s]
  Summary waypoints;       ///< [-] start and goal counted
  Summary cost;            ///< eq. (1)
  Summary samples_used;    ///< [-] of planners that report it
  Summary clearance;       ///< [m]
  Summary tracking_error;  ///< [m]
};

PlanTableRow tableRow(const planning::PlanOptions& options, const std::vector<const PlanRun*>& runs);

/** A row a case. */
std::vector<PlanTableRow> tableRows(const std::vector<planning::PlanOptions>& cases, const std::vector<PlanRun>& runs);

// Header and line of each file, with their ends of line. A cell is empty without a value.
std::string runsHeader();
std::string runsLine(const planning::PlanOptions& options, const PlanRun& run);
std::string tableHeader();
std::string tableLine(const PlanTableRow& row);
std::string comparisonHeader();
std::string comparisonLine(const PlanTableRow& row);

/** Stem of a run's file below paths/: FMTstar_n500_eta0.1_0.5_0_t5_r07. */
std::string pathName(const planning::PlanOptions& options, int run);
/** The tracked path, a row every second millisecond. */
std::string trackCsv(const loop::TrackedPath& track);
/** The plan's waypoints, a row each. */
std::string waypointsCsv(const PlanResult& plan);

/** The paper's Table 2, a line a row, under a heading for each planner and cost. */
std::string tableText(const std::vector<PlanTableRow>& rows);
/** Success and cost over time, a line a row. */
std::string comparisonText(const std::vector<PlanTableRow>& rows);
/** How often which reason ended a run without success: "no_path 3, contact 1"; empty if all were. */
std::string reasonsText(const std::vector<PlanRun>& runs);

}  // namespace raven2_trainer::studies
