#pragma once

#include <string>
#include <vector>

namespace raven2_trainer::config {

/** Of `known` the name that was most likely meant: at most two letters other, missing, too many or changed about, and less than
 * half of them. Of several alike all: `a" or "b`, to stand between quotes. Empty: none. */
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

/** What a message says of a name that nobody knows: the nearest, or all, or, of many, the first. @param[in] what "exercise". */
std::string unknownName(const std::string& what, const std::string& name, const std::vector<std::string>& known);

}  // namespace raven2_trainer::config
