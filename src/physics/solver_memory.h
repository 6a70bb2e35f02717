#pragma once

#include <ode/ode.h>

namespace raven2_trainer::physics {

/**
 * Has ODE take the solver's memory of a world in one piece now, enough for the largest number of contacts, every page
 * of it touched: no step grows it or is the first to touch a page of it, however many contacts come. For a world
 * without bodies that has its own threading implementation. @throw ModelException if there is not so much memory.
 */
void reserveSolverMemory(dWorldID world);

}  // namespace raven2_trainer::physics
