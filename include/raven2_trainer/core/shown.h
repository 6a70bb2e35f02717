#pragma once

#include <cstddef>
#include <string>

namespace raven2_trainer {

/**
 * External text, made safe for a message: at most its first `most` bytes, then "..."; control characters become '?'.
 * Allocates; for set-up only.
 */
inline std::string shown(const std::string& text, std::size_t most) {
  std::string out = text.substr(0, most);
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text.size() > most ? out + "..." : out;
}

}  // namespace raven2_trainer
