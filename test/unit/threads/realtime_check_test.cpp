#include "raven2_trainer/threads/realtime_check.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace raven2_trainer::threads {
namespace {

namespace fs = std::filesystem;

class Environment : public ::testing::Test {
 protected:
  void SetUp() override {
    root = fs::temp_directory_path() / ("raven2_environment_" + std::to_string(getpid()));
    fs::remove_all(root);
    fs::create_directories(root / "share" / "config");
    file = root / "share" / "config" / "runtime.yaml";
    std::ofstream(file) << "x: 1\n";
    for (const fs::path& path : {root, root / "share", root / "share" / "config"})
      ::chmod(path.c_str(), 0755);
    ::chmod(file.c_str(), 0644);
  }
  void TearDown() override { fs::remove_all(root); }

  std::vector<std::string> reasons() const { return writableReasons({file.string()}); }

  fs::path root, file;
};

TEST_F(Environment, FilesOfTheirOwnersAreGood) {
  EXPECT_TRUE(reasons().empty()) << reasons().front();
}

TEST_F(Environment, AFileThatAnybodyMayWriteIsNamed) {
  ::chmod(file.c_str(), 0646);
  ASSERT_EQ(reasons().size(), 1U);
  EXPECT_EQ(reasons()[0], file.string() + " is writable by everybody");
}

TEST_F(Environment, AFolderThatAnybodyMayWriteIsNamedOnceForAllItsFiles) {
  ::chmod(file.parent_path().c_str(), 0757);
  EXPECT_EQ(writableReasons({file.string(), file.string()}),
            std::vector<std::string>{file.parent_path().string() + " is writable by everybody"});
}

TEST_F(Environment, AStickyFolderProtectsTheFoldersInItButNotNewFiles) {
  ::chmod(root.c_str(), 01777);
  EXPECT_TRUE(reasons().empty());
  ::chmod(root.c_str(), 0777);
  EXPECT_EQ(reasons().size(), 1U) << "any user may rename share/ and replace it";
  ::chmod(root.c_str(), 0755);
  ::chmod(file.parent_path().c_str(), 01777);
  EXPECT_EQ(reasons().size(), 1U) << "a scenario may be added to it";
}

TEST_F(Environment, PreloadedLibrariesAreNamed) {
  const std::string preload = (root / "ld.so.preload").string();
  EXPECT_TRUE(preloadReasons(nullptr, preload).empty());
  EXPECT_TRUE(preloadReasons("", preload).empty());
  EXPECT_EQ(preloadReasons("/tmp/evil.so", preload), std::vector<std::string>{"LD_PRELOAD is /tmp/evil.so"});
  std::ofstream(preload).close();
  EXPECT_TRUE(preloadReasons(nullptr, preload).empty());
  std::ofstream(preload) << "/lib/evil.so\n";
  EXPECT_EQ(preloadReasons(nullptr, preload), std::vector<std::string>{preload + " is not empty"});
}

}  // namespace
}  // namespace raven2_trainer::threads
