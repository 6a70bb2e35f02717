#pragma once

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "support/scratch_path.h"

namespace raven2_trainer::session {

using Bytes = std::vector<std::uint8_t>;

using raven2_trainer::testing::scratchPath;

inline Bytes readBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

inline void writeBytes(const std::string& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace raven2_trainer::session
