#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace raven2_trainer::wire {

/** Bytes from a string of hexadecimal digits, as Python's bytes.fromhex. */
inline std::vector<std::uint8_t> fromHex(const std::string& digits) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(digits.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

}  // namespace raven2_trainer::wire
