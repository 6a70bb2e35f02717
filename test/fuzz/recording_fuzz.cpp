#include <cmath>
#include <sstream>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/core/exceptions.h"

// A recording of tips, CSV.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  std::istringstream stream(fuzz::Input(data, size).rest());
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
  return 0;
}
