// Cost of one hook of fault injection in the control program: without a fault, with a fault armed for another place,
// and with an acting fault. For comparison, the same run passes the bare number.
// Usage: fault_hook_benchmark [MILLION CALLS]

#include <time.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "raven2_trainer/faults/fault_engine.h"

namespace raven2_trainer {
namespace {

double processorSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/** Hides the number from the compiler's optimisation. */
double opaque(double value) {
  asm volatile("" : "+m"(value));
  return value;
}

template <typename Pass>
double nanosecondsOf(std::int64_t calls, Pass pass) {
  for (std::int64_t i = 0; i < calls / 10; ++i)
    opaque(pass(opaque(1.0), static_cast<std::size_t>(i) % kJointCount));
  const double begin = processorSeconds();
  for (std::int64_t i = 0; i < calls; ++i)
    opaque(pass(opaque(1.0), static_cast<std::size_t>(i) % kJointCount));
  return 1e9 * (processorSeconds() - begin) / static_cast<double>(calls);
}

faults::FaultEngine armed(FaultVariable variable) {
  FaultPlan plan;
  plan.generation = 1;
  plan.count = 1;
  Fault& fault = plan.faults[0];
  fault.id = 1;
  fault.variable = variable;
  fault.site = infoOf(variable).site;
  fault.kind = FaultKind::kAdd;
  fault.trigger = FaultTrigger::kHand;
  fault.value = 1.0;
  faults::FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(plan);
  engine.beginCycle({});
  return engine;
}

void print(const char* what, double ns, double bare) {
  std::printf("%-28s %6.2f ns a call, the hook %6.2f ns\n", what, ns, ns - bare);
}

int run(std::int64_t calls) {
  faults::FaultEngine idle(FaultHost::kRobot), elsewhere = armed(FaultVariable::kMvel),
                                               here = armed(FaultVariable::kDac);
  const auto through = [](faults::FaultEngine* engine) {
    return [engine](double value, std::size_t joint) {
      return engine->apply(FaultVariable::kDac, Arm::kGold, joint, value);
    };
  };
  const double bare = nanosecondsOf(calls, [](double value, std::size_t) { return value; });
  print("bare", bare, bare);
  print("nothing armed", nanosecondsOf(calls, through(&idle)), bare);
  print("armed elsewhere", nanosecondsOf(calls, through(&elsewhere)), bare);
  print("acting", nanosecondsOf(calls, through(&here)), bare);
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  const long millions = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 50;
  return raven2_trainer::run(static_cast<std::int64_t>(millions > 0 ? millions : 1) * 1'000'000);
}
