#pragma once

#include <algorithm>
#include <string>

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

// Names, counts and bounds of places that several files of config/ share.

namespace raven2_trainer::config {

constexpr double kFarthest = 1.0;         ///< [m] from the middle of the scene, farther than an arm reaches
constexpr std::size_t kLongestName = 32;  ///< letters

inline bool isName(const std::string& text) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !text.empty() && text.size() <= kLongestName && std::all_of(text.begin(), text.end(), fits);
}

/** @throw ConfigException if `root` has more than `most` entries under `key`. */
inline void checkCount(const Section& root, const std::string& key, std::size_t count, std::size_t most) {
  if (count <= most) return;
  throw ConfigException(root.where(key) + " has " + std::to_string(count) + " entries, at most " +
                        std::to_string(most) + " are allowed");
}

}  // namespace raven2_trainer::config
