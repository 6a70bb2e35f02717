#pragma once

namespace raven2_trainer::python {

/** Docstring of "Class.member" in the type stubs (python/raven2_trainer/__init__.pyi).
 *  @throw std::logic_error if the stubs say nothing of it. */
const char* doc(const char* name);

}  // namespace raven2_trainer::python
