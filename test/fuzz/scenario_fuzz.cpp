#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"

// A scenario file. Input: a byte (even: the text follows; odd: edits of the packaged scenario, fuzz_target.h), the
// rest.

namespace raven2_trainer::fuzz {
namespace {

void requireSane(const Fault& fault) {
  require(std::isfinite(fault.value) && std::abs(fault.value) <= 32768.0, "a fault's value is in range");
  require(fault.duration_ticks >= 1 && fault.period_ticks >= 0 && fault.count >= 0, "a fault's times are in range");
  require(fault.kind != FaultKind::kNone && fault.target != FaultTarget::kNone, "a fault does something");
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static const fuzz::ScratchFolder scratch;
  static const std::string packaged = fuzz::readWhole(fuzz::sourceFile("config/faults/sudden_jump.yaml"));
  fuzz::Input input(data, size);
  const bool edits = (input.byte() & 1U) != 0;
  const std::string file = scratch.write("sudden_jump.yaml", edits ? fuzz::edited(packaged, &input) : input.rest());
  try {
    fuzz::requireSane(config::loadScenario(file, 1).fault);
  } catch (const ConfigException& e) {
    fuzz::requirePlace(e.what(), file);
  }
  return 0;
}
