#pragma once

#include <cstddef>

#include <ode/ode.h>

namespace raven2_trainer::physics {

/**
 * Has ODE take two pieces of `bytes` for the solver of a world now, every page of them touched: no step that fits grows
 * them or is the first to touch a page. For a world without bodies that has its own threading implementation.
 * @throw ModelException if there is not so much memory.
 */
void reserveSolverMemory(dWorldID world, std::size_t bytes);

}  // namespace raven2_trainer::physics
