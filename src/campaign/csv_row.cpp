#include "campaign/csv_row.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "raven2_trainer/campaign/results.h"
#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::campaign {
namespace {

constexpr std::array<const char*, 35> kColumns{"scenario",
                                               "run",
                                               "seed",
                                               "outcome",
                                               "injection",
                                               "phase",
                                               "host",
                                               "site",
                                               "variable",
                                               "kind",
                                               "arm",
                                               "channel",
                                               "value",
                                               "low",
                                               "high",
                                               "first_tick",
                                               "duration_ticks",
                                               "half_period_ticks",
                                               "repetition",
                                               "motion_seed",
                                               "injected_ms",
                                               "deviation_mm",
                                               "jump_mm",
                                               "jump_ms",
                                               "estop",
                                               "estop_ms",
                                               "seen",
                                               "reported",
                                               "force_ms",
                                               "force_n",
                                               "motion_mm",
                                               "golden_motion_mm",
                                               "started",
                                               "program",
                                               "finite"};

constexpr double kMillimetres = 1e3;

std::size_t columnOf(const std::string& column) {
  return static_cast<std::size_t>(std::find(kColumns.begin(), kColumns.end(), column) - kColumns.begin());
}

/** Cells of one row. */
class Row {
 public:
  void text(const std::string& cell) { line_ += (line_.empty() ? "" : ",") + cell; }
  void number(std::int64_t value) { text(std::to_string(value)); }
  /** Empty if it never came. */
  void ticks(std::int64_t value) { text(value == kNever ? "" : std::to_string(value)); }
  void real(const char* format, double value) {
    char cell[48];
    std::snprintf(cell, sizeof(cell), format, value);
    text(cell);
  }
  void empty(std::size_t cells) {
    for (std::size_t i = 0; i < cells; ++i)
      line_ += ",";
  }
  const std::string& line() const { return line_; }

 private:
  std::string line_;
};

std::string channelName(const Fault& fault) {
  if (fault.channel < 0) return channelsOf(fault.variable).count == 1 ? "" : "all";
  const auto channel = static_cast<std::size_t>(fault.channel);
  const FaultChannelNames& channels = channelsOf(fault.variable);
  const bool is_named = channel < channels.names.size() && channels.names[channel] != nullptr;
  return is_named ? channels.names[channel] : std::to_string(channel);
}

std::string armName(const Fault& fault) {
  if (!infoOf(fault.variable).per_arm) return "";
  return fault.arm < 0 ? "both" : kArmNames[static_cast<std::size_t>(fault.arm)];
}

void addFault(const Fault& fault, Row* row) {
  row->text(kFaultHostNames[static_cast<std::size_t>(fault.host)]);
  row->text(kFaultSiteNames[static_cast<std::size_t>(fault.site)]);
  row->text(infoOf(fault.variable).name);
  row->text(kFaultKindNames[static_cast<std::size_t>(fault.kind)]);
  row->text(armName(fault));
  row->text(channelName(fault));
  row->real("%.9g", fault.value);
  row->real("%.9g", fault.low);
  row->real("%.9g", fault.high);
  row->number(fault.first_tick);
  row->number(fault.duration_ticks);
  row->number(fault.half_period_ticks);
}

const char* stopName(const Figures& figures) {
  if (figures.software_stop != kNever && figures.plc_stop != kNever) return "both";
  if (figures.software_stop != kNever) return "software";
  return figures.plc_stop != kNever ? "plc" : "none";
}

/** [ticks] the first of two times, either of which may never come. */
std::int64_t first(std::int64_t a, std::int64_t b) {
  if (a == kNever || b == kNever) return a == kNever ? b : a;
  return a < b ? a : b;
}

double larger(const PerArm<double>& values) {
  return values[0] > values[1] ? values[0] : values[1];
}

void addFigures(const Figures& figures, Row* row) {
  row->ticks(figures.injected);
  row->real("%.4f", maxDeviation(figures) * kMillimetres);
  row->real("%.4f", figures.max_jump * kMillimetres);
  row->ticks(figures.jumped);
  row->text(stopName(figures));
  row->ticks(first(figures.software_stop, figures.plc_stop));
  row->number(figures.software_stop != kNever ? 1 : 0);
  row->text(figures.plc_stop == kNever ? "" : figures.reported != kNever ? "1" : "0");
  row->ticks(figures.force);
  row->real("%.3f", figures.max_force);
  row->real("%.4f", larger(figures.motion) * kMillimetres);
  row->real("%.4f", larger(figures.golden_motion) * kMillimetres);
  row->text(figures.golden_started == 0 ? "" : figures.started != 0 ? "1" : "0");
  constexpr std::array<const char*, 3> kPrograms{"running", "hung", "crashed"};
  row->text(kPrograms[static_cast<std::size_t>(figures.program)]);
  row->number(figures.is_finite);
}

constexpr std::size_t kFigureCells = 15;

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells{""};
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

}  // namespace

std::string header() {
  Row row;
  for (const char* column : kColumns)
    row.text(column);
  return row.line();
}

std::string row(const Campaign& campaign, const CampaignRun& run, const RunResult& result) {
  const Experiment& experiment = campaign.experiments[run.experiment];
  Row row;
  row.text(experiment.name);
  row.number(run.number);
  row.text(std::to_string(run.seed));
  row.text(name(classify(result.ending, result.figures, campaign.limits)));
  row.number(experiment.injection);
  row.text(kPhaseNames[static_cast<std::size_t>(run.phase)]);
  addFault(run.plan.faults[0], &row);
  row.number(run.repetition);
  row.text(std::to_string(run.motion_seed));
  if (result.ending == Ending::kComplete) {
    addFigures(result.figures, &row);
  } else {
    row.empty(kFigureCells - 2);
    row.text(kEndingNames[static_cast<std::size_t>(result.ending)]);
    row.empty(1);
  }
  return row.line();
}

std::uint32_t runOf(const std::string& line) {
  const std::vector<std::string> cells = cellsOf(line);
  if (cells.size() != kColumns.size() || cells[1].empty() || cells[1].size() > 9 ||
      cells[1].find_first_not_of("0123456789") != std::string::npos)
    return 0;
  return static_cast<std::uint32_t>(std::stoul(cells[1]));
}

std::uint32_t runOf(const std::string& line, const Campaign& campaign) {
  const std::uint32_t number = runOf(line);
  if (number == 0 || number > campaign.runs.size()) return 0;
  const CampaignRun& run = campaign.runs[number - 1];
  const std::vector<std::string> cells = cellsOf(line);
  const bool fits = cells[0] == campaign.experiments[run.experiment].name && cells[2] == std::to_string(run.seed);
  return fits ? number : 0;
}

bool hasOutcome(const std::string& line) {
  return outcomeOf(line) != name(Outcome::kNone);
}

std::string outcomeOf(const std::string& line) {
  return cellsOf(line)[columnOf("outcome")];
}

bool neverActed(const std::string& line) {
  const std::vector<std::string> cells = cellsOf(line);
  const bool has_figures = !cells[columnOf("estop")].empty();  // a process that died reports nothing
  return has_figures && cells[columnOf("injected_ms")].empty();
}

}  // namespace raven2_trainer::campaign
