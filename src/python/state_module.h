#pragma once

#include <pybind11/pybind11.h>

namespace raven2_trainer::python {

/** Class State: the newest numbers of a simulation, as views of its memory. */
void addState(pybind11::module_* target);

/** The State of a simulation, which it keeps alive. */
pybind11::object newestState(pybind11::object simulation);

}  // namespace raven2_trainer::python
