#include "raven2_trainer/console/commands_file.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>

#include "csv.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {
namespace {

constexpr std::size_t kPerArm = 8;
constexpr std::size_t kColumns = 2 + 2 * kPerArm;
constexpr double kMostTicks = 1e9;
// The daemon checks each packet against its own limits. These only keep the console's whole numbers from overflowing.
// A jaw command adds up while the jaws do not follow.
constexpr double kMostMotion = 1.0;   ///< [m] in a millisecond
constexpr double kMostJaw = 1e5;      ///< [rad]
constexpr double kUnitWithin = 1e-6;  ///< of a quaternion's length
constexpr std::array<const char*, kPerArm> kNames{"move_x", "move_y", "move_z", "turn_x",
                                                  "turn_y", "turn_z", "turn_w", "jaw"};

std::string header() {
  std::string text = "ticks,pedal";
  for (const Arm arm : kArms)
    for (const char* const column : kNames)
      text += std::string(",") + name(arm) + "_" + column;
  return text;
}

std::string columnName(std::size_t column) {
  if (column < 2) return column == 0 ? "ticks" : "pedal";
  return std::string(name(column < 2 + kPerArm ? Arm::kGold : Arm::kGreen)) + "_" + kNames[(column - 2) % kPerArm];
}

double cell(const std::string& path,
            std::size_t line,
            std::size_t column,
            std::string_view text,
            double low,
            double high) {
  const std::optional<double> value = numberOf(text);
  if (!value || *value < low || *value > high) {
    std::array<char, 64> range{};
    std::snprintf(range.data(), range.size(), "[%g, %g]", low, high);
    failAt(path, line,
           columnName(column) + " is \"" + std::string(text) + "\", expected a number in " + std::string(range.data()));
  }
  return *value;
}

void readArm(const std::string& path,
             std::size_t line,
             const std::vector<std::string_view>& cells,
             Arm arm,
             HandsCommand* command) {
  const std::size_t first = 2 + kPerArm * index(arm);
  for (std::size_t i = 0; i < 3; ++i)
    at(command->move_I, arm)[i] = cell(path, line, first + i, cells[first + i], -kMostMotion, kMostMotion);
  Quat& turn = at(command->turn_I, arm);
  for (std::size_t i = 0; i < 4; ++i)
    turn[i] = cell(path, line, first + 3 + i, cells[first + 3 + i], -1.0 - kUnitWithin, 1.0 + kUnitWithin);
  const double length = toEigen(turn).norm();
  if (std::abs(length - 1.0) > kUnitWithin)
    failAt(path, line, std::string(name(arm)) + "_turn has the length " + std::to_string(length) + ", expected 1");
  at(command->grasp, arm) = cell(path, line, first + 7, cells[first + 7], -kMostJaw, kMostJaw);
}

CommandRow readRow(const std::string& path, std::size_t line, const std::string& text) {
  demandShort(path, line, text);
  const std::vector<std::string_view> cells = split(text);
  if (cells.size() != kColumns)
    failAt(path, line, std::to_string(cells.size()) + " columns, expected " + std::to_string(kColumns));
  CommandRow row;
  const double ticks = cell(path, line, 0, cells[0], 1.0, kMostTicks);
  const double pedal = cell(path, line, 1, cells[1], 0.0, 1.0);
  if (ticks != std::floor(ticks) || pedal != std::floor(pedal)) failAt(path, line, "ticks and pedal are whole numbers");
  row.ticks = static_cast<std::uint32_t>(ticks);
  row.command.pedal = pedal == 1.0;
  for (const Arm arm : kArms)
    readArm(path, line, cells, arm, &row.command);
  return row;
}

bool same(const HandsCommand& a, const HandsCommand& b) noexcept {
  return a.pedal == b.pedal && a.move_I == b.move_I && a.turn_I == b.turn_I && a.grasp == b.grasp;
}

void append(std::string* text, double value) {
  std::array<char, 32> digits{};  // the shortest text that is read as the same number
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  *text += ',';
  text->append(digits.data(), end);
}

/** The rows one after the other, then hands at rest with the pedal up. */
class CommandsOfFile : public CommandedSource {
 public:
  CommandsOfFile(const ConsoleConfig& config, const PerArm<double>& opening, std::vector<CommandRow> rows)
      : CommandedSource(config, opening), rows_(std::move(rows)) {}

  Intent tick(const Senses& senses) override {
    set(next());
    Intent intent = CommandedSource::tick(senses);
    intent.finished = row_ == rows_.size();
    return intent;
  }

 private:
  HandsCommand next() {
    if (row_ == rows_.size()) {
      HandsCommand rest;
      rest.grasp = {grasp(Arm::kGold), grasp(Arm::kGreen)};
      return rest;
    }
    const CommandRow& row = rows_[row_];
    if (++ticks_ == row.ticks) {
      ++row_;
      ticks_ = 0;
    }
    return row.command;
  }

  const std::vector<CommandRow> rows_;
  std::size_t row_{0};
  std::uint32_t ticks_{0};  ///< of this row
};

}  // namespace

std::vector<CommandRow> readCommands(std::istream& stream, const std::string& path) {
  std::string line;
  if (!std::getline(stream, line)) failAt(path, 1, "the file of commands cannot be read or is empty");
  if (trimmed(line) != header()) failAt(path, 1, "expected the columns " + header());
  std::vector<CommandRow> rows;
  for (std::size_t number = 2; std::getline(stream, line); ++number)
    rows.push_back(readRow(path, number, line));
  if (rows.empty()) failAt(path, 2, "0 rows, expected at least 1");
  return rows;
}

std::vector<CommandRow> loadCommands(const std::string& path) {
  std::ifstream file(path);
  return readCommands(file, path);
}

std::unique_ptr<MotionSource> makeCommanded(const ConsoleConfig& config,
                                            const PerArm<double>& opening,
                                            std::vector<CommandRow> rows) {
  return std::make_unique<CommandsOfFile>(config, opening, std::move(rows));
}

CommandWriter::CommandWriter(std::ostream* stream) : stream_(*stream) {
  stream_ << header() << '\n';
}

void CommandWriter::add(const HandsCommand& command) {
  if (row_.ticks > 0 && !same(row_.command, command)) flush();
  row_.command = command;
  ++row_.ticks;
}

void CommandWriter::flush() {
  if (row_.ticks == 0) return;
  std::string text = std::to_string(row_.ticks) + (row_.command.pedal ? ",1" : ",0");
  for (const Arm arm : kArms) {
    for (const double value : at(row_.command.move_I, arm))
      append(&text, value);
    for (const double value : at(row_.command.turn_I, arm))
      append(&text, value);
    append(&text, at(row_.command.grasp, arm));
  }
  stream_ << text << '\n';
  row_.ticks = 0;
}

}  // namespace raven2_trainer::console
