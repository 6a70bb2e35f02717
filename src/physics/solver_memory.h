#pragma once

#include <ode/ode.h>

namespace raven2_trainer::physics {

/** Has ODE take the solver's memory of a world in one piece now, large enough for the largest number of contacts and
 * with every page touched: no step grows it, and none is the first to touch a page of it, however many contacts come.
 *  For a world without bodies. */
void reserveSolverMemory(dWorldID world) noexcept;

}  // namespace raven2_trainer::physics
