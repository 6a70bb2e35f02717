#include "raven2_trainer/session/session_directory.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "log_file.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/file_size_limit.h"

namespace raven2_trainer::session {
namespace {

namespace fs = std::filesystem;
using raven2_trainer::testing::FileSizeLimit;

/** An empty folder of this test. */
std::string freshFolder(const std::string& name) {
  const std::string path = scratchPath(name);
  fs::remove_all(path);
  return path;
}

void writeText(const std::string& path, const std::string& text) {
  writeBytes(path, Bytes(text.begin(), text.end()));
}

TEST(SessionDirectory, IsCreatedWithItsParents) {
  const std::string path = freshFolder("parents") + "/a/b";
  const SessionPaths paths = createSessionDirectory(path);
  EXPECT_TRUE(fs::is_directory(path));
  EXPECT_EQ(paths.log(), path + "/session.rlog");
}

TEST(SessionDirectory, RefusesOneThatHoldsASession) {
  const std::string path = freshFolder("taken");
  createSessionDirectory(path);
  EXPECT_NO_THROW(createSessionDirectory(path)) << "an empty folder is taken";
  writeText(path + "/session.rlog", "x");
  EXPECT_THROW(createSessionDirectory(path), SessionException);
}

TEST(SessionDirectory, RefusesAPathThatIsAFile) {
  writeText(scratchPath("file"), "x");
  EXPECT_THROW(createSessionDirectory(scratchPath("file")), SessionException);
  EXPECT_THROW(createSessionDirectory(scratchPath("file") + "/below"), SessionException);
}

TEST(SessionDirectory, IsNamedByItsUtcTimeUnlessGiven) {
  const std::string root = freshFolder("stamped");
  fs::create_directories(root);
  const fs::path before = fs::current_path();
  fs::current_path(root);
  std::set<std::string> directories;
  for (int i = 0; i < 8; ++i)  // of which at least four are of one second
    directories.insert(createSessionDirectory("").directory);
  fs::current_path(before);
  EXPECT_EQ(directories.size(), 8U);
  const std::regex stamp(R"(sessions/\d{4}-\d\d-\d\dT\d\d-\d\d-\d\dZ(-\d+)?)");
  for (const std::string& directory : directories) {
    EXPECT_TRUE(std::regex_match(directory, stamp)) << directory;
    EXPECT_TRUE(fs::is_directory(root + "/" + directory)) << directory;
  }
}

TEST(SessionDirectory, OpensOnlyWithALog) {
  const std::string path = freshFolder("open");
  EXPECT_THROW(openSessionDirectory(path), SessionException);
  createSessionDirectory(path);
  EXPECT_THROW(openSessionDirectory(path), SessionException);
  writeText(path + "/session.rlog", "x");
  EXPECT_EQ(openSessionDirectory(path).metrics(), path + "/metrics.json");
}

TEST(FileHash, IsFnv1a64) {
  // published test vectors of the algorithm (RFC 9923; isthe.com/chongo/src/fnv/test_fnv.c)
  writeText(scratchPath("empty"), "");
  EXPECT_EQ(fileHash(scratchPath("empty")), "cbf29ce484222325");
  writeText(scratchPath("a"), "a");
  EXPECT_EQ(fileHash(scratchPath("a")), "af63dc4c8601ec8c");
  writeText(scratchPath("foobar"), "foobar");
  EXPECT_EQ(fileHash(scratchPath("foobar")), "85944171f73967e8");
  EXPECT_EQ(textHash(""), "cbf29ce484222325");
  EXPECT_EQ(textHash("foobar"), "85944171f73967e8");
  EXPECT_THROW(fileHash(scratchPath("missing_file")), SessionException);
  EXPECT_THROW(fileHash(::testing::TempDir()), SessionException);
}

/** The data that a ConfigSource refers to. */
struct Configured {
  std::vector<std::string> files;
  std::map<std::string, std::string> overridden;
  std::string robot_urdf, scene_urdf, hazard;
  std::uint64_t seed{};

  operator ConfigSource() const { return {files, overridden, robot_urdf, scene_urdf, hazard, seed}; }
};

TEST(SessionMeta, HoldsWhatWasGiven) {
  const SessionPaths paths = createSessionDirectory(freshFolder("meta"));
  const std::string file = scratchPath("haptics.yaml");
  writeText(file, "foobar");
  Configured config;
  config.seed = 18446744073709551615ULL;
  config.hazard = "sudden_jump";
  config.files = {file};
  config.robot_urdf = file;
  SessionMeta meta{"simulate", "0.1.0", "2026-01-31T12:00:00Z", 12.5, "lockstep", "scripted"};
  writeMeta(paths, meta, config);
  const Bytes bytes = readBytes(paths.meta());
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end());
  EXPECT_EQ(json.at("program"), "simulate");
  EXPECT_EQ(json.at("version"), "0.1.0");
  EXPECT_EQ(json.at("start_time_utc"), "2026-01-31T12:00:00Z");
  EXPECT_EQ(json.at("wall_duration_s"), 12.5);
  EXPECT_EQ(json.at("realtime"), "lockstep");
  EXPECT_EQ(json.at("motion"), "scripted");
  EXPECT_EQ(json.at("seed"), config.seed);
  EXPECT_EQ(json.at("hazard"), "sudden_jump");
  EXPECT_EQ(json.at("config_files").at(0).at("fnv1a"), "85944171f73967e8");
  EXPECT_EQ(json.at("robot_urdf").at("fnv1a"), "85944171f73967e8");
  EXPECT_FALSE(json.contains("scene_urdf"));
  EXPECT_FALSE(json.at("config_files").at(0).contains("overridden"));
}

TEST(SessionMeta, TellsWhichFilesWereNotReadAsTheyStand) {
  const SessionPaths paths = createSessionDirectory(freshFolder("meta_overridden"));
  const std::string file = scratchPath("overridden.yaml");
  writeText(file, "a");
  Configured config;
  config.files = {file};
  config.overridden[file] = "foobar";
  writeMeta(paths, {}, config);
  const Bytes bytes = readBytes(paths.meta());
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end());
  EXPECT_EQ(json.at("config_files").at(0).at("fnv1a"), "85944171f73967e8") << "of what was read";
  EXPECT_EQ(json.at("config_files").at(0).at("overridden"), true);
}

SessionMeta makeMeta(const std::string& version) {
  SessionMeta meta;
  meta.version = version;
  meta.start_time_utc = "2026-01-31T12:00:00Z";
  meta.build = {{"compiler", "gcc"}, {"flags", "-O2"}};
  return meta;
}

TEST(SessionMeta, IsReadAsItWasWritten) {
  const SessionPaths paths = createSessionDirectory(freshFolder("meta_read"));
  EXPECT_EQ(readStartTime(paths), "") << "no file yet";
  EXPECT_TRUE(readBuild(paths).empty());
  writeMeta(paths, makeMeta("1"), Configured{});
  EXPECT_EQ(readStartTime(paths), "2026-01-31T12:00:00Z");
  EXPECT_EQ(readBuild(paths), makeMeta("1").build);
  writeText(paths.meta(), R"({"start_time_utc": 7, "build": {"compiler": 7, "flags": "-O2"}})");
  EXPECT_EQ(readStartTime(paths), "");
  EXPECT_EQ(readBuild(paths), (std::map<std::string, std::string>{{"flags", "-O2"}}));
}

TEST(SessionMeta, TellsAllFilesOfTheConfigurationWithTheirHashes) {
  const SessionPaths paths = createSessionDirectory(freshFolder("meta_files"));
  EXPECT_TRUE(readConfigurationFiles(paths).empty()) << "no file yet";
  std::vector<std::pair<std::string, std::string>> expected;
  for (const char* name : {"console.yaml", "robot.urdf", "scene.urdf"}) {
    const std::string file = scratchPath(name);
    writeText(file, name);
    expected.emplace_back(file, textHash(name));
  }
  Configured config;
  config.files = {expected[0].first};
  config.robot_urdf = expected[1].first;
  config.scene_urdf = expected[2].first;
  writeMeta(paths, {}, config);
  EXPECT_EQ(readConfigurationFiles(paths), expected);
}

TEST(SessionMeta, OfAFullDiskIsTheOneFromBefore) {
  const SessionPaths paths = createSessionDirectory(freshFolder("meta_full"));
  writeMeta(paths, makeMeta("1"), Configured{});
  const Bytes before = readBytes(paths.meta());
  {
    const FileSizeLimit limit(20);
    EXPECT_THROW(writeMeta(paths, makeMeta("2"), Configured{}), SessionException);
  }
  EXPECT_EQ(readBytes(paths.meta()), before);
  writeMeta(paths, makeMeta("2"), Configured{});
  EXPECT_NE(readBytes(paths.meta()), before);
}

}  // namespace
}  // namespace raven2_trainer::session
