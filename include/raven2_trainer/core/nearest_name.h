#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace raven2_trainer {

/** Of `known` the name that was most likely meant: at most `most_mistakes` letters other, missing, too many or changed
 * about, and less than half of them. Of several equal ones all: `a" or "b`, for a place between quotes. Empty without
 * one. */
std::string nearestName(const std::string& name, const std::vector<std::string>& known, std::size_t most_mistakes = 2);

/** The message about an unknown name: it suggests the nearest known one, else it lists the known ones, 20 at most.
 * @param[in] what "exercise". */
std::string unknownName(const std::string& what, const std::string& name, const std::vector<std::string>& known);

/** The nearest name as the end of a message, `: did you mean "gold"?`; empty without one. */
std::string didYouMean(const std::string& name, const std::vector<std::string>& known, std::size_t most_mistakes = 2);

/** The end of a message about a word that is not among `known`: `: did you mean "gold"?` or `, expected one of: gold,
 * green`. */
std::string expectedOneOf(const std::string& name, const std::vector<std::string>& known);

}  // namespace raven2_trainer
