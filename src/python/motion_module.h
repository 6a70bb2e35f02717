#pragma once

#include <pybind11/pybind11.h>

namespace raven2_trainer::python {

/** The class Kinematics of the module: forward, inverse and Jacobian of the arms. */
void addKinematics(pybind11::module_* module);
/** The class Planner of the module: FMT* in the scene of an exercise. */
void addPlanner(pybind11::module_* module);

}  // namespace raven2_trainer::python
