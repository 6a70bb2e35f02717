#include <array>
#include <cmath>
#include <cstring>

#include "fuzz/fuzz_target.h"
#include "raven/network_layer.h"
#include "raven2_trainer/core/fault_variables.h"

// The robot's own receiver. It accepts the same packets as the original: any values, with its own order rule, here with
// the packet faults of a fuzzed plan. The poses may become NaN, as in the original. But no value causes undefined
// behaviour, and every packet is counted.
// Input: a fault (16 bytes), then datagrams as in itp_fuzz.cpp; a longer one is cut to 124 bytes.

namespace raven2_trainer::fuzz {
namespace {

FaultPlan readPlan(Input* input) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  Fault& fault = plan.faults[0];
  fault.id = 1;
  fault.host = FaultHost::kRobot;
  fault.site = FaultSite::kNetworkLayer;
  constexpr std::array<FaultVariable, 7> kVariables{
      FaultVariable::kIncrement, FaultVariable::kPedal,    FaultVariable::kQuaternion, FaultVariable::kTurn,
      FaultVariable::kGrasp,     FaultVariable::kSequence, FaultVariable::kPacket};
  fault.variable = kVariables[input->byte() % kVariables.size()];
  fault.kind = static_cast<FaultKind>(input->byte() % kFaultKindCount);
  fault.arm = static_cast<std::int8_t>(input->byte() % 3 - 1);
  fault.channel = static_cast<std::int8_t>(input->byte() % 4 - 1);
  fault.first_tick = input->byte();
  fault.duration_ticks = input->byte();
  fault.period_ticks = input->byte();
  fault.count = input->byte();
  const Bytes value = input->take(sizeof(fault.value));
  if (!value.empty()) std::memcpy(&fault.value, value.data(), value.size());
  fault.low = std::trunc(fault.value / 2.0);
  fault.high = fault.value;
  if (!isSound(fault)) plan.count = 0;  // the link refuses such a plan
  return plan;
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  fuzz::Input input(data, size);
  faults::FaultEngine faults(FaultHost::kRobot);
  faults.setPlan(fuzz::readPlan(&input));
  VirtualRavenConfig config;
  config.behaviour = "compat";
  config.master_timeout = 200;
  raven::NetworkLayer robot(config, nullptr);
  std::int64_t time_ns = 0;
  while (!input.empty()) {
    const std::uint8_t kind = input.byte();
    const fuzz::Bytes bytes = input.take((kind & 1U) == 0 ? wire::kItpSize : kind / 2U);
    faults.beginCycle({robot.pedal(), 3, {}});
    const std::uint64_t applied = robot.counts().applied;
    robot.release(&faults);
    const std::uint64_t released = robot.counts().applied;
    robot.receive({bytes.data(), bytes.size(), 1, time_ns += kTickNanoseconds}, &faults);
    fuzz::require(robot.counts().addsUp(), "received = applied + rejected");
    fuzz::require(bytes.size() >= wire::kItpSize || robot.counts().applied == released, "a short datagram is refused");
    fuzz::require(released >= applied, "nothing is taken back");
    robot.tick();
    for (const Arm arm : kArms)
      robot.target(arm).pose();
  }
  return 0;
}
