#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace raven2_trainer {

/** The nearest name in `known`: at most `most_mistakes` letters replaced, missing, added or swapped, and fewer than
 * half. Equally near names are joined for use inside quotes: `a" or "b`. Empty if no name is near. */
std::string nearestName(const std::string& name, const std::vector<std::string>& known, std::size_t most_mistakes = 2);

/** Message about an unknown name: suggests the nearest known one, else lists at most 20.
 * @param[in] what Kind of name, such as "exercise". */
std::string unknownName(const std::string& what, const std::string& name, const std::vector<std::string>& known);

/** The nearest name as the end of a message, `: did you mean "gold"?`; empty without one. */
std::string didYouMean(const std::string& name, const std::vector<std::string>& known, std::size_t most_mistakes = 2);

/** The end of a message about a word that is not among `known`: `: did you mean "gold"?` or `, expected one of: gold,
 * green`. */
std::string expectedOneOf(const std::string& name, const std::vector<std::string>& known);

}  // namespace raven2_trainer
