#include "raven2_trainer/faults/arming.h"

#include <algorithm>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::faults {
namespace {

constexpr std::uint64_t kDrillStream = 0xD1;  // of the seed: a number for each attempt, in order

/** [s] */
double drawJitter(const FaultLibrary& library, std::uint32_t attempt) {
  Random random(library.seed, kDrillStream);
  double jitter = 0.0;
  for (std::uint32_t i = 0; i < attempt; ++i)
    jitter = random.uniform(0.0, library.trigger.jitter);
  return jitter;
}

/** Of the row that begins first. */
Tick firstTick(const FaultPlan& plan) {
  Tick first = plan.count == 0 ? 0 : plan.faults[0].first_tick;
  for (std::size_t i = 1; i < plan.count; ++i)
    first = std::min(first, plan.faults[i].first_tick);
  return first;
}

}  // namespace

std::uint32_t idOf(const std::vector<Scenario>& scenarios, const std::string& name) noexcept {
  for (const Scenario& scenario : scenarios) {
    if (scenario.name == name) return scenario.faults[0].id;
  }
  return 0;
}

FaultPlan planFor(const FaultLibrary& library, std::uint32_t id, std::uint64_t generation) {
  FaultPlan plan;
  plan.generation = generation;
  if (!library.injection.enable || id == 0 || id > library.scenarios.size()) return plan;
  for (Fault fault : library.scenarios[id - 1].faults) {
    fault.seed += library.seed;
    plan.faults[plan.count++] = fault;
  }
  return plan;
}

FaultPlan immediatePlan(const FaultLibrary& library, std::uint32_t id, std::uint64_t generation) {
  FaultPlan plan = planFor(library, id, generation);
  const Tick first = firstTick(plan);
  for (std::size_t i = 0; i < plan.count; ++i) {
    plan.faults[i].trigger = FaultTrigger::kHand;
    plan.faults[i].first_tick -= first;
  }
  return plan;
}

bool isDrill(const FaultLibrary& library) noexcept {
  return library.drill != "none" && library.hazard == library.drill;
}

FaultPlan drillPlan(const FaultLibrary& library, std::uint32_t attempt, std::uint64_t generation) {
  FaultPlan plan;
  plan.generation = generation;
  if (!isDrill(library)) return plan;
  plan = planFor(library, idOf(library.scenarios, library.drill), generation);
  const ExerciseDrill& drill = library.trigger;
  const auto shot = toTicks(drill.delay + drawJitter(library, attempt));
  const Tick first = firstTick(plan);
  std::for_each(plan.faults.begin(), plan.faults.begin() + plan.count, [&](Fault& fault) {
    fault.trigger = FaultTrigger::kStep;
    fault.threshold = drill.step;
    fault.first_tick += shot - first;
    fault.period_ticks = 0;
    fault.count = 1;
    fault.probability = 1.0;
  });
  return plan;
}

}  // namespace raven2_trainer::faults
