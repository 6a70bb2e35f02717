#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace raven2_trainer::testing {

/** A folder of this process alone. It is removed when the process ends normally. */
class ScratchFolder {
 public:
  ScratchFolder() : path_((std::filesystem::path(::testing::TempDir()) / "raven2_XXXXXX").string()) {
    if (::mkdtemp(path_.data()) == nullptr) throw std::runtime_error("no folder can be made like " + path_);
  }
  ~ScratchFolder() {
    std::error_code kept;  // ignored: nobody could receive an error any more
    std::filesystem::remove_all(path_, kept);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/** The path of that name in the process's scratch folder. */
inline std::string scratchPath(const std::string& name) {
  static const ScratchFolder folder;
  return folder.path() + "/" + name;
}

}  // namespace raven2_trainer::testing
