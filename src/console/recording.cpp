#include <array>
#include <cmath>
#include <istream>
#include <string>
#include <string_view>

#include "csv.h"
#include "raven2_trainer/console/console.h"

namespace raven2_trainer::console {
namespace {

constexpr std::size_t kColumns = 6;
constexpr std::array<const char*, kColumns> kNames{"gold_x_um",  "gold_y_um",  "gold_z_um",
                                                   "green_x_um", "green_y_um", "green_z_um"};
constexpr double kMetresPerMicrometre = 1e-6;
constexpr double kLimitUm = 1e6;  ///< a tip is never a metre from its remote centre
constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

using Cells = std::vector<std::string_view>;

std::array<std::size_t, kColumns> readHeader(const std::string& path, const std::string& line) {
  const Cells cells = split(line);
  std::array<std::size_t, kColumns> places;
  places.fill(kAbsent);
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    for (std::size_t column = 0; column < kColumns; ++column) {
      if (cells[cell] != kNames[column]) continue;
      if (places[column] != kAbsent) failAt(path, 1, std::string("column ") + kNames[column] + " appears twice");
      places[column] = cell;
    }
  }
  for (std::size_t column = 0; column < kColumns; ++column) {
    if (places[column] == kAbsent) failAt(path, 1, std::string("column ") + kNames[column] + " is missing");
  }
  return places;
}

/** @return [m] */
double readNumber(const std::string& path, std::size_t line, const char* name, std::string_view text) {
  const std::optional<double> value = numberOf(text);
  if (!value || std::abs(*value) > kLimitUm) {
    failAt(path, line, std::string(name) + " is \"" + std::string(text) + "\", expected a number in [-1e6, 1e6] um");
  }
  return *value * kMetresPerMicrometre;
}

}  // namespace

Recording readRecording(std::istream& stream, const std::string& path) {
  std::string line;
  if (!std::getline(stream, line)) throw ConfigException(path + ":1: recording cannot be read or is empty");
  const auto places = readHeader(path, line);
  Recording recording;
  for (std::size_t number = 2; std::getline(stream, line); ++number) {
    demandShort(path, number, line);
    const Cells cells = split(line);
    PerArm<Vec3> tips{};
    for (std::size_t column = 0; column < kColumns; ++column) {
      const std::string_view text = places[column] < cells.size() ? cells[places[column]] : std::string_view{};
      tips[column / 3][column % 3] = readNumber(path, number, kNames[column], text);
    }
    recording.tips.push_back(tips);
  }
  if (recording.tips.empty()) failAt(path, 2, "0 rows, expected at least 1");
  return recording;
}

}  // namespace raven2_trainer::console
