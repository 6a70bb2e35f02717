#include "raven2_trainer/studies/plan_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace raven2_trainer::studies {
namespace {

planning::PlanOptions options(std::uint32_t samples = 500) {
  planning::PlanOptions o;
  o.planner = "FMTstar";
  o.samples = samples;
  o.max_samples = 4000;
  o.eta_length = 0.1;
  o.eta_acceleration = 0.5;
  o.time_limit = 5.0;
  return o;
}

PlanRun good(double time, double cost, std::uint32_t samples = 500) {
  PlanRun run;
  run.run = 7;
  run.seed = 8;
  run.result.status = PlanStatus::kSuccess;
  run.result.samples = samples;
  run.result.waypoint_count = 3;
  run.result.cost = cost;
  run.result.planning_time = time;
  run.result.clearance = 0.004;
  run.result.tracking_error = 0.0005;
  run.track.duration = 3.5;
  run.track.error = 0.0006;
  return run;
}

PlanRun failed(double time) {
  PlanRun run;
  run.result.status = PlanStatus::kNoPath;
  run.result.planning_time = time;
  return run;
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all;
  std::string cell;
  std::istringstream in(line.substr(0, line.find('\n')));
  while (std::getline(in, cell, ','))
    all.push_back(cell);
  if (!line.empty() && line[line.size() - 2] == ',') all.emplace_back();
  return all;
}

/** Cell below a column's name. */
std::string under(const std::string& column, const std::string& header, const std::string& line) {
  const std::vector<std::string> names = cells(header), values = cells(line);
  EXPECT_EQ(names.size(), values.size());
  const auto place = std::find(names.begin(), names.end(), column);
  EXPECT_NE(place, names.end()) << column;
  return values.at(static_cast<std::size_t>(place - names.begin()));
}

TEST(Summary, IsThatOfHandNumbers) {
  // 2, 4, 4, 4, 5, 5, 7, 9: mean 5, squares of the differences 9 + 1 + 1 + 1 + 0 + 0 + 4 + 16 = 32, over 7
  const Summary s = summarise({9, 2, 4, 5, 4, 7, 4, 5});
  EXPECT_EQ(s.count, 8U);
  EXPECT_DOUBLE_EQ(s.mean, 5.0);
  EXPECT_DOUBLE_EQ(s.deviation, std::sqrt(32.0 / 7.0));
  EXPECT_DOUBLE_EQ(s.median, 4.5);
  EXPECT_EQ(s.least, 2.0);
  EXPECT_EQ(s.greatest, 9.0);
  EXPECT_DOUBLE_EQ(summarise({3, 1, 8}).median, 3.0);
}

TEST(Summary, TellsNothingWhereThereIsNothing) {
  EXPECT_TRUE(std::isnan(summarise({}).mean));
  EXPECT_TRUE(std::isnan(summarise({}).median));
  EXPECT_EQ(summarise({3.0}).median, 3.0);
  EXPECT_TRUE(std::isnan(summarise({3.0}).deviation));
}

TEST(PlanRun, IsASuccessOnlyIfBothRollOutAndSessionTouchNothing) {
  EXPECT_TRUE(isSuccess(good(1, 1)));
  EXPECT_STREQ(reasonOf(good(1, 1)), "success");
  PlanRun touched = good(1, 1);
  touched.track.has_touched = true;
  PlanRun lost = good(1, 1);
  lost.track.has_failed = true;
  PlanRun close = good(1, 1);
  close.result.clearance = 0.0;
  for (const PlanRun& run : {touched, lost, close}) {
    EXPECT_FALSE(isSuccess(run));
    EXPECT_STREQ(reasonOf(run), "contact");
  }
  EXPECT_FALSE(isSuccess(failed(1)));
  EXPECT_STREQ(reasonOf(failed(1)), "no_path");
}

TEST(PlanTable, TimesAreOfAllRunsAndPathsOfTheSuccesses) {
  PlanRun touched = good(5.0, 100.0);
  touched.track.has_touched = true;
  const std::vector<PlanRun> runs{good(1.0, 2.0), good(2.0, 4.0, 750), failed(4.0), touched};
  const std::vector<PlanTableRow> rows = tableRows({options()}, runs);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].runs, 4);
  EXPECT_EQ(rows[0].successes, 2);
  EXPECT_EQ(rows[0].exact_successes, 1) << "the other one needed 750 samples";
  EXPECT_DOUBLE_EQ(rows[0].planning_time.mean, 3.0);
  EXPECT_DOUBLE_EQ(rows[0].planning_time.median, 3.0);
  EXPECT_DOUBLE_EQ(rows[0].cost.mean, 3.0);
  EXPECT_DOUBLE_EQ(rows[0].cost.deviation, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(rows[0].samples_used.mean, 625.0);
  const std::string line = tableLine(rows[0]);
  EXPECT_EQ(under("success_percent", tableHeader(), line), "50");
  EXPECT_EQ(under("success_at_n_percent", tableHeader(), line), "25");
  EXPECT_EQ(under("planning_time_greatest_s", tableHeader(), line), "5");
  EXPECT_EQ(under("cost_median", tableHeader(), line), "3");
  EXPECT_EQ(under("tracking_time_mean_s", tableHeader(), line), "3.5");
  EXPECT_EQ(under("clearance_least_m", tableHeader(), line), "0.004");
  EXPECT_EQ(under("tracking_error_greatest_mm", tableHeader(), line), "0.5");
}

TEST(PlanTable, RunsGoToTheirCases) {
  std::vector<PlanRun> runs{good(1, 1), good(1, 2), good(1, 3)};
  runs[1].case_index = runs[2].case_index = 1;
  const std::vector<PlanTableRow> rows = tableRows({options(200), options(500)}, runs);
  EXPECT_EQ(rows[0].cost.count, 1U);
  EXPECT_DOUBLE_EQ(rows[1].cost.mean, 2.5);
}

TEST(PlanTable, ACaseWithoutSuccessHasEmptyCells) {
  const std::string line = tableLine(tableRows({options()}, {failed(1.0)})[0]);
  EXPECT_EQ(under("success_percent", tableHeader(), line), "0");
  EXPECT_EQ(under("cost_mean", tableHeader(), line), "");
  EXPECT_EQ(under("tracking_error_greatest_mm", tableHeader(), line), "");
  EXPECT_EQ(under("planning_time_mean_s", tableHeader(), line), "1");
}

TEST(PlanTable, WhatOmplsPlannersDoNotTellIsLeftEmpty) {
  for (const char* planner : planning::kPlannerNames) {
    planning::PlanOptions stock = options();
    stock.planner = planner;
    PlanRun run = good(1.0, 2.0, std::string(planner) == "FMTstar" ? 500 : 0);
    run.statistics.draws = 1234;
    const std::vector<PlanTableRow> rows = tableRows({stock}, {run});
    const std::string line = tableLine(rows[0]), row = runsLine(stock, run);
    // GIVEN that FMTstar and FMT take n samples, and only FMTstar reports how many it kept
    const bool is_ours = std::string(planner) == "FMTstar", has_n = is_ours || std::string(planner) == "FMT";
    EXPECT_EQ(under("success_percent", tableHeader(), line), "100") << planner;
    EXPECT_EQ(under("success_at_n_percent", tableHeader(), line), has_n ? "100" : "") << planner;
    EXPECT_EQ(under("samples_used_mean", tableHeader(), line), is_ours ? "500" : "") << planner;
    EXPECT_EQ(under("samples_used", runsHeader(), row), is_ours ? "500" : "") << planner;
    EXPECT_EQ(under("sampling_time_s", runsHeader(), row), is_ours ? "0" : "") << planner;
    EXPECT_EQ(under("neighbour_time_s", runsHeader(), row), is_ours ? "0" : "") << planner;
    EXPECT_EQ(under("draws", runsHeader(), row), "1234") << planner;
    EXPECT_EQ(under("samples", comparisonHeader(), comparisonLine(rows[0])), has_n ? "500" : "") << planner;
    EXPECT_NE(tableText(rows).find(has_n ? "100 (100)" : "100 (-)"), std::string::npos) << planner;
  }
}

TEST(PlanRuns, TheFirstColumnsAreThosePromised) {
  const std::string first =
      "samples,run,seed,success,reason,planning_time_s,tracking_time_s,waypoints,cost,clearance_m,tracking_error_mm,";
  EXPECT_EQ(runsHeader().compare(0, first.size(), first), 0);
}

TEST(PlanRuns, ARowOfASuccess) {
  PlanRun run = good(0.25, 0.0911, 750);
  run.seed = 9007199254740991;  // the program's greatest seed; a run can be repeated only with all its digits
  run.statistics.edge_checks = 123456789;
  run.statistics.rollout_time = 0.02;
  const std::string line = runsLine(options(), run);
  EXPECT_EQ(line.compare(0, 60, "500,7,9007199254740991,1,success,0.25,3.5,3,0.0911,0.004,0.5"), 0) << line;
  EXPECT_EQ(under("samples_used", runsHeader(), line), "750");
  EXPECT_EQ(under("edge_checks", runsHeader(), line), "123456789");
  EXPECT_EQ(under("rollout_time_s", runsHeader(), line), "0.02");
  EXPECT_EQ(under("session_error_mm", runsHeader(), line), "0.6");
  EXPECT_EQ(under("touched", runsHeader(), line), "0");
  EXPECT_EQ(under("path", runsHeader(), line), "FMTstar_n500_eta0.1_0.5_0_t5_r07");
}

TEST(PlanRuns, ARowOfAFailureTellsNoPath) {
  const std::string line = runsLine(options(), failed(0.5));
  EXPECT_EQ(line.compare(0, 31, "500,0,0,0,no_path,0.5,,,,,,FMTs"), 0) << line;
  EXPECT_EQ(under("path", runsHeader(), line), "");
}

TEST(PlanComparison, AnytimePlannersHaveNoSampleCount) {
  planning::PlanOptions anytime = options();
  anytime.planner = "BITstar";
  anytime.time_limit = 0.1;
  anytime.until_time_limit = true;
  const std::string line = comparisonLine(tableRows({anytime}, {good(0.1, 2.0), good(0.1, 1.0)})[0]);
  EXPECT_EQ(under("planner", comparisonHeader(), line), "BITstar");
  EXPECT_EQ(under("samples", comparisonHeader(), line), "");
  EXPECT_EQ(under("time_s", comparisonHeader(), line), "0.1");
  EXPECT_EQ(under("success_percent", comparisonHeader(), line), "100");
  EXPECT_EQ(under("cost_median", comparisonHeader(), line), "1.5");
  EXPECT_EQ(under("cost_least", comparisonHeader(), line), "1");
}

TEST(PlanPaths, TracksAndWaypointsAreRows) {
  loop::TrackedPath track;
  track.samples.push_back({0.002, 1, {1, 2, 3}, {4, 5, 6}, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}});
  EXPECT_EQ(trackCsv(track),
            "time_s,waypoint,x_m,y_m,z_m,x_desired_m,y_desired_m,z_desired_m,q1,q2,q3,q4,q5,q6,q7\n"
            "0.002,1,1,2,3,4,5,6,0.1,0.2,0.3,0.4,0.5,0.6,0.7\n");
  PlanResult plan;
  plan.waypoint_count = 2;
  plan.waypoints[1] = {1, 2, 3, 4, 5, 6, 7};
  plan.arrival[1] = 1.5;
  EXPECT_EQ(waypointsCsv(plan), "waypoint,arrival_s,q1,q2,q3,q4,q5,q6,q7\n0,0,0,0,0,0,0,0,0\n1,1.5,1,2,3,4,5,6,7\n");
}

TEST(PlanPaths, EveryRunHasAFileOfItsOwn) {
  planning::PlanOptions other = options();
  other.eta_clearance = 0.1;
  planning::PlanOptions later = options();
  later.time_limit = 10.0;
  const std::vector<std::string> names{pathName(options(), 1), pathName(options(), 11), pathName(options(200), 1),
                                       pathName(other, 1), pathName(later, 1)};
  for (std::size_t i = 0; i < names.size(); ++i)
    EXPECT_EQ(std::count(names.begin(), names.end(), names[i]), 1) << names[i];
}

TEST(PlanText, ColumnsStandUnderEachOther) {
  planning::PlanOptions clear = options(2000);
  clear.eta_clearance = 0.1;
  std::vector<PlanRun> runs{good(1, 1), good(3, 1), failed(123.456)};
  runs[2].case_index = 1;
  const std::string text = tableText(tableRows({options(200), clear}, runs));
  EXPECT_EQ(text,
            "FMTstar, eta 0.1, 0.5, 0\n"
            "samples      planning time [s]   tracking time [s]        waypoints              cost eq. (1)"
            "  success [%] (at n)\n"
            "    200  2.000 ± 1.414 (2.000)  3.50 ± 0.00 (3.50)  3.0 ± 0.0 (3.0)  1.0000 ± 0.0000 (1.0000)"
            "             100 (0)\n"
            "\n"
            "FMTstar, eta 0.1, 0.5, 0.1 (clearance term on)\n"
            "samples  planning time [s]  tracking time [s]  waypoints  cost eq. (1)  success [%] (at n)\n"
            "   2000            123.456                  -          -             -               0 (0)\n")
      << text;
}

TEST(PlanText, ReasonsAreCounted) {
  PlanRun touched = good(1, 1);
  touched.track.has_touched = true;
  EXPECT_EQ(reasonsText({good(1, 1), failed(1), touched, failed(1)}), "contact 1, no_path 2");
  EXPECT_EQ(reasonsText({good(1, 1)}), "");
}

}  // namespace
}  // namespace raven2_trainer::studies
