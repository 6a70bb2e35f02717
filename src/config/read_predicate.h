#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exercise.h"

// Parts of an exercise's file that name parts of its scene (config/load_exercise.h).

namespace raven2_trainer::config {

/** Index of the part that is named under `key`. @throw ConfigException naming those that there are. */
std::uint8_t readObject(Section& section, const std::string& key, const SceneRoles& roles);
std::uint8_t readPeg(Section& section, const std::string& key, const SceneRoles& roles);
std::uint8_t readPoint(Section& section, const std::string& key, const SceneRoles& roles);
/** Pegs named in a list. */
std::vector<std::uint8_t> readPegs(Section& section, const std::string& key, const SceneRoles& roles);

/** @param[in] object of the track; kNobody none. */
Predicate readPredicate(Section& entry, const SceneRoles& roles, std::uint8_t object);

/** Under `key`, 1 to kMaxPredicates. */
std::vector<Predicate> readPredicates(Section& section,
                                      const std::string& key,
                                      const SceneRoles& roles,
                                      std::uint8_t object);

}  // namespace raven2_trainer::config
