#pragma once

#include <vector>

#include "python/simulation.h"

namespace raven2_trainer::python {

/** Steps all of them, each on one of the threads; none if a command is refused. @throw what one of them throws. */
void stepAll(const std::vector<Simulation*>& all,
             const std::vector<StepCommand>& commands,
             int ticks,
             unsigned threads);

}  // namespace raven2_trainer::python
