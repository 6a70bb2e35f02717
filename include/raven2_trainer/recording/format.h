#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace raven2_trainer::recording {

/** printf into a string of up to 511 characters; what is longer is cut. */
template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

}  // namespace raven2_trainer::recording
