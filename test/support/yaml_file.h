#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>

#include "raven2_trainer/core/exceptions.h"

// Configuration files that a test writes, and checks of the error messages about bad ones.

namespace raven2_trainer::testing {

/** A file in a new folder, both removed with this object. */
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& text)
      : folder_(std::filesystem::temp_directory_path() / ("raven2_yaml_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    path_ = (folder_ / name).string();
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove_all(folder_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }
  std::string folder() const { return folder_.string(); }

 private:
  std::filesystem::path folder_;
  std::string path_;
};

/** The text with the first occurrence of `from` replaced. */
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  if (place == std::string::npos) {
    ADD_FAILURE() << from << " is not in the text";
    return text;
  }
  return text.replace(place, from.size(), to);
}

/** Checks that `load` throws, and that the message names this line of the file and contains `says`. */
template <typename Load>
void expectRefused(Load load, const std::string& text, int line, const std::string& says = "") {
  try {
    load(text);
    ADD_FAILURE() << "accepted, but should be refused: line " << line << ", " << says;
  } catch (const ConfigException& e) {
    const std::string said = e.what(), place = ".yaml:" + std::to_string(line) + ":";
    EXPECT_NE(said.find(place), std::string::npos) << said << " | " << place;
    EXPECT_NE(said.find(says), std::string::npos) << said << " | " << says;
  }
}

/** A piece of a good text, the bad piece that replaces it, and the line that the message must name. */
struct BadPiece {
  const char* from;
  const char* to;
  int line;
};

template <typename Load>
void expectEachRefused(Load load, const std::string& good, std::initializer_list<BadPiece> pieces) {
  for (const BadPiece& piece : pieces)
    expectRefused(load, replaced(good, piece.from, piece.to), piece.line);
}

}  // namespace raven2_trainer::testing
