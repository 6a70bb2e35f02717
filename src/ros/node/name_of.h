#pragma once

#include <cstddef>

namespace raven2_trainer::ros_bridge {

/** Name of an enumeration's value; "unknown" for any other value. */
template <typename Names, typename Enum>
const char* nameOf(const Names& names, Enum value) {
  const auto i = static_cast<std::size_t>(value);
  return i < names.size() ? names[i] : "unknown";
}

}  // namespace raven2_trainer::ros_bridge
