#include "raven2_trainer/studies/plan_tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numeric>
#include <type_traits>

#include "studies/number.h"

namespace raven2_trainer::studies {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMillimetres = 1000.0;

/** Cells of one line. */
class Line {
 public:
  Line& operator<<(double value) { return *this << number(value); }
  template <typename Count, typename = std::enable_if_t<std::is_integral<Count>::value>>
  Line& operator<<(Count value) {
    return *this << std::to_string(value);  // to the last digit: seeds go up to 2^53
  }
  Line& operator<<(const std::string& cell) {
    text_ += (is_first_ ? "" : ",") + cell;
    is_first_ = false;
    return *this;
  }
  Line& operator<<(const Summary& s) { return *this << s.mean << s.deviation << s.median; }
  std::string end() const { return text_ + "\n"; }

 private:
  std::string text_;
  bool is_first_{true};
};

/** Names of the three cells of a Summary. */
std::string summaryOf(const std::string& quantity, const std::string& unit = "") {
  const std::string end = unit.empty() ? "" : "_" + unit;
  return quantity + "_mean" + end + "," + quantity + "_deviation" + end + "," + quantity + "_median" + end;
}

double percent(int part, int whole) {
  return whole > 0 ? 100.0 * part / whole : kNaN;
}

/** Without added samples; NaN for a planner that has no n. */
double exactPercent(const PlanTableRow& row) {
  return planning::takesSamples(row.options.planner) ? percent(row.exact_successes, row.runs) : kNaN;
}

bool hasPlan(const PlanRun& run) {
  return run.result.status == PlanStatus::kSuccess;
}

template <typename Value>
Summary over(const std::vector<const PlanRun*>& runs, const Value& value) {
  std::vector<double> values;
  for (const PlanRun* run : runs)
    values.push_back(value(*run));
  return summarise(std::move(values));
}

/** "0.118 ± 0.012 (0.115)": mean, deviation, median. */
std::string cell(const Summary& s, int digits) {
  if (s.count == 0) return "-";
  char text[96];
  if (s.count == 1) {
    std::snprintf(text, sizeof(text), "%.*f", digits, s.mean);
  } else {
    std::snprintf(text, sizeof(text), "%.*f ± %.*f (%.*f)", digits, s.mean, digits, s.deviation, digits, s.median);
  }
  return text;
}

/** Columns of a terminal that UTF-8 text takes: continuation bytes take none. */
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

std::string padded(const std::string& text, std::size_t columns) {
  const std::size_t used = width(text);
  return used < columns ? std::string(columns - used, ' ') + text : text;
}

std::string lineOf(const std::vector<std::string>& cells, const std::vector<std::size_t>& columns) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i)
    line += padded(cells[i], columns[i]) + (i + 1 < cells.size() ? "  " : "\n");
  return line;
}

/** Cells under each other, right-aligned. */
std::string aligned(const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::size_t> columns(lines.empty() ? 0 : lines[0].size());
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i)
      columns[i] = std::max(columns[i], width(line[i]));
  }
  std::string text;
  for (const auto& line : lines)
    text += lineOf(line, columns);
  return text;
}

std::string whole(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.0f", value);
  return std::isfinite(value) ? text : "-";
}

std::string successCell(const PlanTableRow& row) {
  return whole(percent(row.successes, row.runs)) + " (" + whole(exactPercent(row)) + ")";
}

std::string etas(const planning::PlanOptions& o) {
  return number(o.eta_length) + ", " + number(o.eta_acceleration) + ", " + number(o.eta_clearance);
}

std::string heading(const planning::PlanOptions& o) {
  return o.planner + ", eta " + etas(o) + (o.eta_clearance > 0.0 ? " (clearance term on)" : "");
}

bool areAlike(const planning::PlanOptions& a, const planning::PlanOptions& b) {
  return a.planner == b.planner && etas(a) == etas(b);
}

const std::vector<std::string> kTableColumns{"samples",   "planning time [s]", "tracking time [s]",
                                             "waypoints", "cost eq. (1)",      "success [%] (at n)"};

std::vector<std::string> tableCells(const PlanTableRow& row) {
  return {std::to_string(row.options.samples),
          cell(row.planning_time, 3),
          cell(row.tracking_time, 2),
          cell(row.waypoints, 1),
          cell(row.cost, 4),
          successCell(row)};
}

std::string joints(const JointArray& q) {
  std::string text;
  for (const double value : q)
    text += "," + number(value);
  return text;
}

constexpr const char* kJointColumns = ",q1,q2,q3,q4,q5,q6,q7";

}  // namespace

Summary summarise(std::vector<double> values) {
  Summary s;
  s.count = values.size();
  s.mean = s.deviation = s.median = s.least = s.greatest = kNaN;
  if (values.empty()) return s;
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  s.least = values.front();
  s.greatest = values.back();
  s.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  s.median = 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  if (values.size() < 2) return s;
  double squares = 0.0;
  for (const double value : values)
    squares += (value - s.mean) * (value - s.mean);
  s.deviation = std::sqrt(squares / (n - 1.0));
  return s;
}

PlanTableRow tableRow(const planning::PlanOptions& options, const std::vector<const PlanRun*>& runs) {
  std::vector<const PlanRun*> good;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(good), [](const PlanRun* run) { return isSuccess(*run); });
  PlanTableRow row;
  row.options = options;
  row.runs = static_cast<int>(runs.size());
  row.successes = static_cast<int>(good.size());
  row.exact_successes = static_cast<int>(std::count_if(
      good.begin(), good.end(), [&](const PlanRun* run) { return run->result.samples <= options.samples; }));
  row.planning_time = over(runs, [](const PlanRun& run) { return run.result.planning_time; });
  row.tracking_time = over(good, [](const PlanRun& run) { return run.track.duration; });
  row.waypoints = over(good, [](const PlanRun& run) { return static_cast<double>(run.result.waypoint_count); });
  row.cost = over(good, [](const PlanRun& run) { return run.result.cost; });
  const bool reports = planning::reportsSamples(options.planner);
  row.samples_used =
      reports ? over(good, [](const PlanRun& run) { return static_cast<double>(run.result.samples); }) : summarise({});
  row.clearance = over(good, [](const PlanRun& run) { return run.result.clearance; });
  row.tracking_error = over(good, [](const PlanRun& run) { return run.result.tracking_error; });
  return row;
}

std::vector<PlanTableRow> tableRows(const std::vector<planning::PlanOptions>& cases, const std::vector<PlanRun>& runs) {
  std::vector<PlanTableRow> rows;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    std::vector<const PlanRun*> chosen;
    for (const PlanRun& run : runs) {
      if (run.case_index == i) chosen.push_back(&run);
    }
    rows.push_back(tableRow(cases[i], chosen));
  }
  return rows;
}

std::string runsHeader() {
  return "samples,run,seed,success,reason,planning_time_s,tracking_time_s,waypoints,cost,clearance_m,tracking_error_mm,"
         "planner,eta_length,eta_acceleration,eta_clearance,time_limit_s,max_samples,samples_used,draws,state_checks,"
         "edge_checks,cost_evaluations,clearance_integrals,rollouts,failed_rollouts,rounds,plain_cost,improved_cost,"
         "clearance_cost,goal_time_s,sampling_time_s,neighbour_time_s,search_time_s,improvement_time_s,rollout_time_s,"
         "touched,session_error_mm,path\n";
}

std::string runsLine(const planning::PlanOptions& options, const PlanRun& run) {
  const PlanResult& r = run.result;
  const planning::PlanStatistics& s = run.statistics;
  const auto ofPlan = [&](double value) { return hasPlan(run) ? value : kNaN; };
  const auto ifAsked = [&](double value) { return planning::reportsSamples(options.planner) ? value : kNaN; };
  Line line;
  line << options.samples << run.run << run.seed << isSuccess(run) << std::string(reasonOf(run));
  line << r.planning_time << ofPlan(run.track.duration) << ofPlan(r.waypoint_count) << ofPlan(r.cost)
       << ofPlan(r.clearance) << ofPlan(kMillimetres * r.tracking_error);
  line << options.planner << options.eta_length << options.eta_acceleration << options.eta_clearance
       << options.time_limit << options.max_samples << ifAsked(r.samples);
  for (const std::uint64_t count :
       {s.draws, s.state_checks, s.edge_checks, s.cost_evaluations, s.clearance_integrals, std::uint64_t{s.rollouts},
        std::uint64_t{s.failed_rollouts}, std::uint64_t{s.rounds}})
    line << count;
  line << ofPlan(s.plain_cost) << ofPlan(s.improved_cost) << ofPlan(s.clearance_cost);
  for (const double time : {s.goal_time, ifAsked(s.sampling_time), ifAsked(s.neighbour_time), s.search_time,
                            s.improvement_time, s.rollout_time})
    line << time;
  line << ofPlan(run.track.has_touched) << ofPlan(kMillimetres * run.track.error);
  line << (hasPlan(run) ? pathName(options, run.run) : "");
  return line.end();
}

std::string tableHeader() {
  return "planner,eta_length,eta_acceleration,eta_clearance,samples,runs,success_percent,success_at_n_percent," +
         summaryOf("planning_time", "s") + ",planning_time_greatest_s," + summaryOf("tracking_time", "s") + "," +
         summaryOf("waypoints") + "," + summaryOf("cost") + "," + summaryOf("samples_used") +
         ",clearance_least_m,tracking_error_greatest_mm\n";
}

std::string tableLine(const PlanTableRow& row) {
  const planning::PlanOptions& o = row.options;
  Line line;
  line << o.planner << o.eta_length << o.eta_acceleration << o.eta_clearance << o.samples << row.runs;
  line << percent(row.successes, row.runs) << exactPercent(row);
  line << row.planning_time << row.planning_time.greatest << row.tracking_time << row.waypoints << row.cost;
  line << row.samples_used << row.clearance.least << kMillimetres * row.tracking_error.greatest;
  return line.end();
}

std::string comparisonHeader() {
  return "planner,samples,time_s,runs,success_percent," + summaryOf("cost") + ",cost_least," +
         summaryOf("planning_time", "s") + "," + summaryOf("tracking_time", "s") + "\n";
}

std::string comparisonLine(const PlanTableRow& row) {
  const planning::PlanOptions& o = row.options;
  Line line;
  line << o.planner << (planning::takesSamples(o.planner) ? o.samples : kNaN) << o.time_limit << row.runs
       << percent(row.successes, row.runs);
  line << row.cost << row.cost.least << row.planning_time << row.tracking_time;
  return line.end();
}

std::string pathName(const planning::PlanOptions& options, int run) {
  char end[16];
  std::snprintf(end, sizeof(end), "_r%02d", run);
  return options.planner + "_n" + std::to_string(options.samples) + "_eta" + number(options.eta_length) + "_" +
         number(options.eta_acceleration) + "_" + number(options.eta_clearance) + "_t" + number(options.time_limit) +
         end;
}

std::string trackCsv(const loop::TrackedPath& track) {
  std::string text =
      std::string("time_s,waypoint,x_m,y_m,z_m,x_desired_m,y_desired_m,z_desired_m") + kJointColumns + "\n";
  for (const loop::TrackSample& sample : track.samples) {
    Line line;
    line << sample.time << sample.waypoint;
    for (const Vec3& p : {sample.p_W, sample.desired_W})
      line << p[0] << p[1] << p[2];
    const std::string cells = line.end();
    text += cells.substr(0, cells.size() - 1) + joints(sample.q) + "\n";
  }
  return text;
}

std::string waypointsCsv(const PlanResult& plan) {
  std::string text = std::string("waypoint,arrival_s") + kJointColumns + "\n";
  for (std::size_t i = 0; i < plan.waypoint_count; ++i)
    text += std::to_string(i) + "," + number(plan.arrival[i]) + joints(plan.waypoints[i]) + "\n";
  return text;
}

std::string tableText(const std::vector<PlanTableRow>& rows) {
  std::string text;
  for (std::size_t first = 0, end = 0; first < rows.size(); first = end) {
    std::vector<std::vector<std::string>> lines{kTableColumns};
    for (end = first; end < rows.size() && areAlike(rows[first].options, rows[end].options); ++end)
      lines.push_back(tableCells(rows[end]));
    text += (first > 0 ? "\n" : "") + heading(rows[first].options) + "\n" + aligned(lines);
  }
  return text;
}

std::string comparisonText(const std::vector<PlanTableRow>& rows) {
  std::vector<std::vector<std::string>> lines{
      {"planner", "samples", "time [s]", "success [%]", "cost eq. (1)", "least"}};
  for (const PlanTableRow& row : rows) {
    const planning::PlanOptions& o = row.options;
    Summary least = row.cost;
    least.mean = least.least;
    least.count = std::min<std::size_t>(1, least.count);
    const std::string n = planning::takesSamples(o.planner) ? std::to_string(o.samples) : "-";
    lines.push_back({o.planner, n, number(o.time_limit), number(percent(row.successes, row.runs)), cell(row.cost, 4),
                     cell(least, 4)});
  }
  return aligned(lines);
}

std::string reasonsText(const std::vector<PlanRun>& runs) {
  std::map<std::string, int> counts;
  for (const PlanRun& run : runs) {
    if (!isSuccess(run)) ++counts[reasonOf(run)];
  }
  std::string text;
  for (const auto& [reason, count] : counts)
    text += (text.empty() ? "" : ", ") + reason + " " + std::to_string(count);
  return text;
}

}  // namespace raven2_trainer::studies
