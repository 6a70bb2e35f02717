#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/faults/fault_library.h"

namespace raven2_trainer::faults {

/** Fault::id of a scenario by its name; 0 for a name that is not in the library. */
std::uint32_t idOf(const std::vector<Scenario>& scenarios, const std::string& name) noexcept;

/** The plan that arms one scenario (id from idOf; 0 = nothing), drawing from the configuration's seed; an empty one
 *  where injection is not enabled. */
FaultPlan planFor(const FaultLibrary& library, std::uint32_t id, std::uint64_t generation);

/** As planFor(), but the scenario acts at once: its own trigger does not count, and its first row begins in the cycle that
 *  sees it armed. */
FaultPlan immediatePlan(const FaultLibrary& library, std::uint32_t id, std::uint64_t generation);

/** Is the hazard that is armed at the start the exercise's drill? */
bool isDrill(const FaultLibrary& library) noexcept;

/**
 * The drill of one attempt: the rows of its scenario, each to come once and for certain, on the exercise's trigger
 * instead of their own. The first comes `delay` after the exercise's step began, plus a share of `jitter` that is drawn
 * from the configuration's seed and the attempt; the others as long after it as in the scenario. An empty plan without
 * a drill, or where injection is not enabled.
 * @param[in] attempt ExerciseState::attempt.
 */
FaultPlan drillPlan(const FaultLibrary& library, std::uint32_t attempt, std::uint64_t generation);

}  // namespace raven2_trainer::faults
