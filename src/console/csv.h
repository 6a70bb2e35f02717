#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

// Lines of the CSV files that the console reads.

namespace raven2_trainer::console {

[[noreturn]] inline void failAt(const std::string& path, std::size_t line, const std::string& what) {
  throw ConfigException(path + ":" + std::to_string(line) + ": " + what);
}

inline std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

constexpr std::size_t kMaxLine = 4096;  ///< some numbers, and whatever else a logger wrote

inline void demandShort(const std::string& path, std::size_t line, const std::string& text) {
  if (text.size() > kMaxLine) failAt(path, line, "longer than " + std::to_string(kMaxLine) + " characters");
}

/** The cells of a line, without the blanks around them. */
inline std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = line.find(',', begin);
    cells.push_back(trimmed(line.substr(begin, comma - begin)));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

/** @return None for anything but a finite number. */
inline std::optional<double> numberOf(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_number = error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
  return is_number ? std::optional<double>(value) : std::nullopt;
}

}  // namespace raven2_trainer::console
