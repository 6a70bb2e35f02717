#include <cmath>
#include <sstream>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/console/commands_file.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/core/exceptions.h"

// Motion from a file, CSV: a recording of tips, or commands of a program.

namespace raven2_trainer {
namespace {

void readTips(const std::string& text) {
  std::istringstream stream(text);
  try {
    const console::Recording recording = console::readRecording(stream, "fuzzed.csv");
    fuzz::require(!recording.tips.empty(), "a recording has a row");
    for (const auto& tips : recording.tips) {
      for (const Vec3& tip : tips) {
        for (const double x : tip)
          fuzz::require(std::isfinite(x) && std::abs(x) <= 1.0, "a tip is within a metre");
      }
    }
  } catch (const ConfigException& e) {
    fuzz::requirePlace(e.what(), "fuzzed.csv");
  }
}

void readCommands(const std::string& text) {
  std::istringstream stream(text);
  try {
    const std::vector<console::CommandRow> rows = console::readCommands(stream, "fuzzed.csv");
    fuzz::require(!rows.empty(), "commands have a row");
    for (const console::CommandRow& row : rows) {
      fuzz::require(row.ticks > 0, "a command lasts a tick");
      for (const Vec3& move : row.command.move_I) {
        for (const double x : move)
          fuzz::require(std::isfinite(x) && std::abs(x) <= 1.0, "a tick's motion is within a metre");
      }
    }
  } catch (const ConfigException& e) {
    fuzz::requirePlace(e.what(), "fuzzed.csv");
  }
}

}  // namespace
}  // namespace raven2_trainer

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = raven2_trainer::fuzz::Input(data, size).rest();
  raven2_trainer::readTips(text);
  raven2_trainer::readCommands(text);
  return 0;
}
