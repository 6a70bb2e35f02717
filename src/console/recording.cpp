#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <string>
#include <string_view>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::console {
namespace {

constexpr std::size_t kColumns = 6;
constexpr std::array<const char*, kColumns> kNames{"gold_x_um",  "gold_y_um",  "gold_z_um",
                                                   "green_x_um", "green_y_um", "green_z_um"};
constexpr double kMetresPerMicrometre = 1e-6;
constexpr double kLimitUm = 1e6;        ///< a tip is never a metre from its remote centre
constexpr std::size_t kMaxLine = 4096;  ///< six numbers, and whatever else a logger wrote
constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

using Cells = std::vector<std::string_view>;

[[noreturn]] void fail(const std::string& path, std::size_t line, const std::string& what) {
  throw ConfigException(path + ":" + std::to_string(line) + ": " + what);
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

Cells split(std::string_view line) {
  Cells cells;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = line.find(',', begin);
    cells.push_back(trimmed(line.substr(begin, comma - begin)));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

std::array<std::size_t, kColumns> readHeader(const std::string& path, const std::string& line) {
  const Cells cells = split(line);
  std::array<std::size_t, kColumns> places;
  places.fill(kAbsent);
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    for (std::size_t column = 0; column < kColumns; ++column) {
      if (cells[cell] != kNames[column]) continue;
      if (places[column] != kAbsent) fail(path, 1, std::string("column ") + kNames[column] + " appears twice");
      places[column] = cell;
    }
  }
  for (std::size_t column = 0; column < kColumns; ++column) {
    if (places[column] == kAbsent) fail(path, 1, std::string("column ") + kNames[column] + " is missing");
  }
  return places;
}

/** @return [m] */
double readNumber(const std::string& path, std::size_t line, const char* name, std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_number = error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
  if (!is_number || std::abs(value) > kLimitUm) {
    fail(path, line, std::string(name) + " is \"" + std::string(text) + "\", expected a number in [-1e6, 1e6] um");
  }
  return value * kMetresPerMicrometre;
}

}  // namespace

Recording readRecording(std::istream& stream, const std::string& path) {
  std::string line;
  if (!std::getline(stream, line)) throw ConfigException(path + ":1: recording cannot be read or is empty");
  const auto places = readHeader(path, line);
  Recording recording;
  for (std::size_t number = 2; std::getline(stream, line); ++number) {
    if (line.size() > kMaxLine) fail(path, number, "longer than " + std::to_string(kMaxLine) + " characters");
    const Cells cells = split(line);
    PerArm<Vec3> tips{};
    for (std::size_t column = 0; column < kColumns; ++column) {
      const std::string_view text = places[column] < cells.size() ? cells[places[column]] : std::string_view{};
      tips[column / 3][column % 3] = readNumber(path, number, kNames[column], text);
    }
    recording.tips.push_back(tips);
  }
  if (recording.tips.empty()) fail(path, 2, "0 rows, expected at least 1");
  return recording;
}

}  // namespace raven2_trainer::console
