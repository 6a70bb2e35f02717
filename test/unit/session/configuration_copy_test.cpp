#include "raven2_trainer/session/configuration_copy.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::session {
namespace {

namespace fs = std::filesystem;

class ConfigurationCopy : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("raven2_configuration_" + std::to_string(getpid()));
    fs::remove_all(folder);
    for (const char* name : {"share/config/trainer.yaml", "share/config/faults/a.yaml", "share/meshes/a.stl"})
      write(name, std::string("content of ") + name);
    paths = createSessionDirectory((folder / "session").string());
    header.configuration = copyConfiguration(paths, originals());
  }
  void TearDown() override { fs::remove_all(folder); }

  void write(const std::string& name, const std::string& text) {
    fs::create_directories((folder / name).parent_path());
    std::ofstream(folder / name) << text;
  }

  std::vector<std::string> originals() const {
    const std::string share = (folder / "share").string();
    return {share + "/config/trainer.yaml", share + "/config/faults/a.yaml", share + "/config/../meshes/a.stl",
            share + "/config/./trainer.yaml"};
  }

  std::string problem() {
    try {
      checkConfiguration(paths, header);
    } catch (const SessionException& e) {
      return e.what();
    }
    return "";
  }

  fs::path folder;
  SessionPaths paths;
  LogHeader header;
};

TEST_F(ConfigurationCopy, PutsWhatIsBorrowedFromThePackageBesideTheConfiguration) {
  write("home/mine/trainer.yaml", "names ../urdf/robot.urdf, which is not there");
  write("home/mine/faults/a.yaml", "mine");
  write("share/urdf/robot.urdf", "the package's");
  const std::string home = (folder / "home").string(), share = (folder / "share").string();
  const SessionPaths other = createSessionDirectory((folder / "other").string());
  const auto copies = copyConfiguration(
      other,
      {home + "/mine/trainer.yaml", home + "/mine/faults/a.yaml", share + "/urdf/robot.urdf", share + "/meshes/a.stl"},
      {}, {{share + "/urdf/robot.urdf", home + "/urdf/robot.urdf"}, {share + "/meshes/a.stl", home + "/meshes/a.stl"}});
  ASSERT_EQ(copies.size(), 4U);
  EXPECT_EQ(copies[0].path, "configuration/mine/trainer.yaml");
  EXPECT_EQ(copies[1].path, "configuration/mine/faults/a.yaml");
  EXPECT_EQ(copies[2].path, "configuration/urdf/robot.urdf");
  EXPECT_EQ(copies[3].path, "configuration/meshes/a.stl");
}

TEST_F(ConfigurationCopy, LeavesWhatAConfigurationNamesElsewhereWhereItStands) {
  write("home/mine/trainer.yaml", "names ../../share/config/faults/a.yaml");
  const std::string home = (folder / "home").string(), share = (folder / "share").string();
  const SessionPaths other = createSessionDirectory((folder / "other").string());
  const auto copies = copyConfiguration(other, {home + "/mine/trainer.yaml", share + "/config/faults/a.yaml"});
  ASSERT_EQ(copies.size(), 2U);
  EXPECT_EQ(copies[0].path, "configuration/home/mine/trainer.yaml");
  EXPECT_EQ(copies[1].path, "configuration/share/config/faults/a.yaml");
}

TEST_F(ConfigurationCopy, KeepsEachFileAtItsPlaceRelativeToTheOthers) {
  ASSERT_EQ(header.configuration.size(), 3U) << "one given twice is copied once";
  EXPECT_EQ(header.configuration[0].path, "configuration/config/trainer.yaml");
  EXPECT_EQ(header.configuration[1].path, "configuration/config/faults/a.yaml");
  EXPECT_EQ(header.configuration[2].path, "configuration/meshes/a.stl");
  for (const ConfigurationFile& file : header.configuration)
    EXPECT_EQ(fileHash(paths.directory + "/" + file.path), file.fnv1a);
  EXPECT_EQ(checkConfiguration(paths, header), paths.directory + "/configuration/config/trainer.yaml");
}

TEST_F(ConfigurationCopy, OutlivesItsOriginals) {
  fs::remove_all(folder / "share");
  EXPECT_EQ(problem(), "");
}

TEST_F(ConfigurationCopy, ThatChangedOrIsMissingIsRefusedByName) {
  write("session/configuration/config/faults/a.yaml", "content of another");
  EXPECT_NE(problem().find("a.yaml (changed)"), std::string::npos) << problem();
  fs::remove(folder / "session/configuration/meshes/a.stl");
  EXPECT_NE(problem().find("a.yaml (changed), configuration/meshes/a.stl (missing)"), std::string::npos) << problem();
  header.configuration = {{"../../etc/passwd", "0"}};
  EXPECT_NE(problem().find("outside the session"), std::string::npos) << "a log may come from anybody";
  header.configuration.clear();
  EXPECT_NE(problem().find("no copy"), std::string::npos);
}

TEST_F(ConfigurationCopy, OfWhatWasOverriddenIsWhatWasRead) {
  const std::string share = (folder / "share").string();
  const auto copies =
      copyConfiguration(paths, originals(), {{share + "/config/faults/../faults/a.yaml", "overridden"}});
  ASSERT_EQ(copies.size(), 3U);
  for (const ConfigurationFile& file : copies) {
    std::ifstream copy(paths.directory + "/" + file.path);
    const std::string text{std::istreambuf_iterator<char>(copy), {}};
    const bool is_overridden = file.path == "configuration/config/faults/a.yaml";
    EXPECT_EQ(text == "overridden", is_overridden) << file.path << ": " << text;
    EXPECT_EQ(file.fnv1a, textHash(text));
  }
}

}  // namespace
}  // namespace raven2_trainer::session
