#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/campaign/plan.h"

namespace raven2_trainer::campaign {

/** The run that a row is of; 0 if it is not a whole row. */
std::uint32_t runOf(const std::string& line);
/** The same; 0 also if the campaign has no such run, or another scenario or seed for it. */
std::uint32_t runOf(const std::string& line, const Campaign& campaign);
/** Of a row: whether its run came to an end that says something. */
bool hasOutcome(const std::string& line);
/** The outcome in a row. */
std::string outcomeOf(const std::string& line);
/** Of a row: whether its run went to its horizon without its fault. */
bool neverActed(const std::string& line);

}  // namespace raven2_trainer::campaign
