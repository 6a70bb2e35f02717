#include "raven2_trainer/plant/motor_recording.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::plant {
namespace {

constexpr std::size_t kLeastRows = 200;
constexpr double kLargestAngle = 1e6;  // [deg] 2800 turns; a 24-bit encoder has 4194
constexpr std::array<const char*, 6> kColumns{"mpos1_deg", "mpos2_deg", "mpos3_deg", "dac1", "dac2", "dac3"};

std::vector<std::string> split(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> cells;
  std::size_t begin = 0;
  for (std::size_t end = line.find(','); end != std::string::npos; end = line.find(',', begin)) {
    cells.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  cells.push_back(line.substr(begin));
  return cells;
}

std::array<std::size_t, kColumns.size()> findColumns(const std::vector<std::string>& header, const std::string& where) {
  std::array<std::size_t, kColumns.size()> found{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto place = std::find(header.begin(), header.end(), kColumns[i]);
    if (place == header.end()) throw ConfigException(where + ": column " + kColumns[i] + " is missing");
    found[i] = static_cast<std::size_t>(place - header.begin());
  }
  return found;
}

double number(const std::string& cell, double bound, const std::string& where) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (cell.empty() || *end != '\0' || !(std::abs(value) <= bound)) {
    throw ConfigException(where + ": \"" + cell + "\", expected a number in +-" + std::to_string(bound));
  }
  return value;
}

MotorRecording::Row readRow(const std::vector<std::string>& cells,
                            const std::array<std::size_t, kColumns.size()>& columns,
                            const std::string& where) {
  if (cells.size() <= *std::max_element(columns.begin(), columns.end())) {
    throw ConfigException(where + ": " + std::to_string(cells.size()) + " cells are too few");
  }
  MotorRecording::Row row;
  for (std::size_t i = 0; i < 3; ++i) {
    row.position[i] = number(cells[columns[i]], kLargestAngle, where) * kPi / 180.0;
    row.dac[i] = static_cast<std::int16_t>(std::lround(number(cells[columns[3 + i]], 32767, where)));
  }
  return row;
}

}  // namespace

MotorRecording loadMotorRecording(const std::string& path) {
  std::ifstream stream(path);
  std::string line;
  if (!std::getline(stream, line)) throw ConfigException(path + ":1: recording cannot be read or is empty");
  const auto columns = findColumns(split(line), path + ":1");
  MotorRecording recording;
  for (std::size_t number = 2; std::getline(stream, line); ++number) {
    recording.rows.push_back(readRow(split(line), columns, path + ":" + std::to_string(number)));
    if (number == 2) continue;
    MotorRecording::Row& row = recording.rows.back();
    const MotorRecording::Row& before = *(recording.rows.end() - 2);
    for (std::size_t i = 0; i < 3; ++i)
      row.rate[i] = (row.position[i] - before.position[i]) / kTickSeconds;
  }
  if (recording.rows.size() < kLeastRows) {
    throw ConfigException(path + ": " + std::to_string(recording.rows.size()) + " rows, expected at least " +
                          std::to_string(kLeastRows));
  }
  return recording;
}

}  // namespace raven2_trainer::plant
