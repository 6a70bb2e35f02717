#include <cmath>
#include <cstdio>

#include "raven2_trainer/studies/replay.h"

namespace raven2_trainer::studies {
namespace {

constexpr double kDegrees = 180.0 / kPi;  // /ravenstate multiplies everything, metres included (raven2.md 5.2)

void append(std::string* row, const char* format, double value) {
  char text[64];
  const double shown = std::isnan(value) ? std::nan("") : value;  // never "-nan"
  std::snprintf(text, sizeof(text), format, shown);
  row->push_back(',');
  row->append(text);
}

void append(std::string* row, std::int32_t value) {
  row->push_back(',');
  row->append(std::to_string(value));
}

template <typename Array>
void appendAll(std::string* row, const char* format, const Array& values, double factor) {
  for (const auto value : values)
    append(row, format, factor * value);
}

template <std::size_t N>
void appendAll(std::string* row, const std::array<std::int32_t, N>& values) {
  for (const std::int32_t value : values)
    append(row, value);
}

void nameAll(std::string* header, const char* name, int count) {
  for (int k = 0; k < count; ++k)
    header->append(",").append(name).append(std::to_string(k));
}

}  // namespace

std::string stateTraceHeader() {
  std::string header = "t_s,last_seq,runlevel,sublevel";
  nameAll(&header, "pos", 6);
  nameAll(&header, "pos_d", 6);
  nameAll(&header, "ori", 18);
  nameAll(&header, "ori_d", 18);
  for (const char* name : {"jpos", "jpos_d", "mpos", "mpos_d", "mvel", "dac_val", "tau"})
    nameAll(&header, name, static_cast<int>(kRavenChannels));
  nameAll(&header, "grasp_d", 2);
  return header + "\n";
}

std::string stateTraceRow(double t_s, const RavenReport& report) {
  char time[64];
  std::snprintf(time, sizeof(time), "%.6f", t_s);
  std::string row(time);
  row.append(",").append(std::to_string(static_cast<std::uint32_t>(report.last_sequence)));
  append(&row, report.runlevel);
  append(&row, report.sublevel);
  appendAll(&row, report.pos_um);
  appendAll(&row, report.pos_d_um);
  appendAll(&row, "%.4f", report.ori, 1.0);
  appendAll(&row, "%.6f", report.ori_d, 1.0);
  appendAll(&row, "%.4f", report.jpos, kDegrees);
  appendAll(&row, "%.5f", report.jpos_d, kDegrees);
  appendAll(&row, "%.2f", report.mpos, kDegrees);
  appendAll(&row, "%.3f", report.mpos_d, kDegrees);
  appendAll(&row, "%.0f", report.mvel, kDegrees);
  appendAll(&row, report.dac);
  appendAll(&row, "%.4f", report.tau, 1.0);
  appendAll(&row, "%.5f", report.grasp_d, 1.0);
  row.push_back('\n');
  return row;
}

}  // namespace raven2_trainer::studies
