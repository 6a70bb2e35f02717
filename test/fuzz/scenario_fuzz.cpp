#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/config/load_scenario.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"

// A scenario file. Input: a byte (even: the text follows; odd: edits of the packaged scenario, fuzz_target.h), the
// rest.

namespace raven2_trainer::fuzz {
namespace {

void requireSane(const Fault& fault) {
  require(isSound(fault), "an engine can work with it");
  require(fault.kind != FaultKind::kNone && fault.variable != FaultVariable::kNone, "a fault does something");
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
    for (const Fault& fault : config::loadScenario(file, 1, {"net_delay_1", "wan"}).faults)
      fuzz::requireSane(fault);
  } catch (const ConfigException& e) {
    fuzz::requirePlace(e.what(), file);
  }
  return 0;
}
