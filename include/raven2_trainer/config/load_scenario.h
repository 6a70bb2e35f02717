#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/faults/fault_library.h"
#include "raven2_trainer/faults/scenario.h"

namespace raven2_trainer::config {

class Section;

/**
 * One scenario file; its form is described in doc/hazards.md.
 * @param[in] id becomes Fault::id. @param[in] impairments names that kind `impair` may use.
 * @throw ConfigException with FILE:LINE for an unknown site, variable, channel or kind, a kind that the variable does
 * not take, a value out of the variable's range (core/fault_variables.h) and a trigger that can never fire.
 */
Scenario loadScenario(const std::string& path, std::uint32_t id, const std::vector<std::string>& impairments);

/** One row of a scenario, which is all that `row` may hold. @throw ConfigException as above. */
Fault readFault(Section& row, std::uint32_t id, const std::vector<std::string>& impairments);

/** A file like config/injection.yaml alone: the two keys of fault injection. @throw ConfigException with FILE:LINE. */
InjectionConfig loadInjection(const std::string& path);

}  // namespace raven2_trainer::config
