#pragma once

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace raven2_trainer::session {

using Bytes = std::vector<std::uint8_t>;

/** A path of this process alone in the test's scratch folder. */
inline std::string scratchPath(const std::string& name) {
  return testing::TempDir() + "/raven2_" + std::to_string(getpid()) + "_" + name;
}

inline Bytes readBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

inline void writeBytes(const std::string& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace raven2_trainer::session
