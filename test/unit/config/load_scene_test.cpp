#include "raven2_trainer/config/load_scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <tuple>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "support/yaml_file.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/scenes";

const std::string kGood =
    "title: A test\n"
    "urdf: scene.urdf\n"
    "objects:\n"
    "  ring: {link: ring_link, shape: round, inner_radius: 0.0075, bar_radius: 0.002}\n"
    "  frame: {link: frame_link, shape: square, inner_radius: 0.007, bar_radius: 0.0021}\n"
    "  block: {link: block_link, shape: solid}\n"
    "pegs:\n"
    "  a: {link: peg_a, base_W: [0.01, -0.02, 0.003], height: 0.026, radius: 0.004}\n"
    "wires:\n"
    "  left: {link: wire_left, radius: 0.00125, line_W: [[0, 0, 0], [0, 0.01, 0.02], [0.03, 0.01, 0.02]]}\n"
    "breakables:\n"
    "  - {link: peg_a, force: 6.0, moment: 0.06, ticks: 5}\n"
    "tissue: [plate, dome]\n"
    "points: {middle: [0.01, 0, 0.045]}\n"
    "regions:\n"
    "  box: {low_W: [-0.1, -0.2, 0], high_W: [0.1, 0.2, 0.3]}\n"
    "parking: true\n";

class LoadScene : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("raven2_scene_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "scene.urdf") << "<robot/>";
  }
  void TearDown() override { fs::remove_all(folder_); }

  SceneRoles load(const std::string& content) const {
    std::ofstream(folder_ / "probe.yaml") << content;
    return loadScene((folder_ / "probe.yaml").string());
  }

  /** The good file with one piece of its text replaced. */
  static std::string with(const std::string& what, const std::string& instead) {
    return raven2_trainer::testing::replaced(kGood, what, instead);
  }

  void expectRefused(const std::string& content, int line, const std::string& says) const {
    raven2_trainer::testing::expectRefused([this](const std::string& text) { return load(text); }, content, line, says);
  }

  fs::path folder_;
};

TEST_F(LoadScene, EverythingIsRead) {
  const SceneRoles roles = load(kGood);
  EXPECT_EQ(roles.name, "probe");
  EXPECT_EQ(roles.title, "A test");
  EXPECT_EQ(roles.file, (folder_ / "probe.yaml").string());
  EXPECT_EQ(roles.urdf, (folder_ / "scene.urdf").string());
  ASSERT_EQ(roles.pegs.size(), 1U);
  EXPECT_EQ(roles.pegs[0].name + " " + roles.pegs[0].link, "a peg_a");
  EXPECT_EQ(roles.pegs[0].base_W, (Vec3{0.01, -0.02, 0.003}));
  EXPECT_EQ(roles.pegs[0].height, 0.026);
  EXPECT_EQ(roles.pegs[0].radius, 0.004);
  ASSERT_EQ(roles.wires.size(), 1U);
  EXPECT_EQ(roles.wires[0].radius, 0.00125);
  EXPECT_EQ(roles.wires[0].line_W, (std::vector<Vec3>{{0, 0, 0}, {0, 0.01, 0.02}, {0.03, 0.01, 0.02}}));
  ASSERT_EQ(roles.breakables.size(), 1U);
  EXPECT_EQ(roles.breakables[0].link, "peg_a");
  EXPECT_EQ(roles.breakables[0].force, 6.0);
  EXPECT_EQ(roles.breakables[0].moment, 0.06);
  EXPECT_EQ(roles.breakables[0].ticks, 5);
  EXPECT_EQ(roles.tissue, (std::vector<std::string>{"plate", "dome"}));
  ASSERT_EQ(roles.points.size(), 1U);
  EXPECT_EQ(roles.points[0].p_W, (Vec3{0.01, 0, 0.045}));
  ASSERT_EQ(roles.regions.size(), 1U);
  EXPECT_EQ(roles.regions[0].high_W, (Vec3{0.1, 0.2, 0.3}));
  EXPECT_EQ(roles.parking, 1);
}

TEST_F(LoadScene, ObjectsKeepTheirOrderAndTheirOpenings) {
  const SceneRoles roles = load(kGood);
  ASSERT_EQ(roles.objects.size(), 3U);
  EXPECT_EQ(roles.objects[0].link, "ring_link");
  EXPECT_EQ(roles.objects[0].square, 0);
  EXPECT_EQ(roles.objects[0].inner_radius, 0.0075);
  EXPECT_EQ(roles.objects[1].name, "frame");
  EXPECT_EQ(roles.objects[1].square, 1);
  EXPECT_EQ(roles.objects[1].bar_radius, 0.0021);
  EXPECT_EQ(roles.objects[2].inner_radius, 0.0) << "solid: nothing passes through";
}

TEST_F(LoadScene, MappingsAndListsMayBeEmpty) {
  const SceneRoles roles = load(
      "title: Bare\nurdf: scene.urdf\nobjects: {}\npegs: {}\nwires: {}\nbreakables: []\ntissue: []\npoints: {}\n"
      "regions: {}\nparking: false\n");
  EXPECT_TRUE(roles.objects.empty() && roles.breakables.empty() && roles.regions.empty());
  EXPECT_EQ(roles.parking, 0);
}

TEST_F(LoadScene, EveryKeyMustBeThereAndNoOther) {
  for (const char* key : {"title",   "urdf",    "objects", "pegs",  "wires",        "breakables", "tissue", "points",
                          "regions", "parking", "link",    "shape", "inner_radius", "bar_radius", "base_W", "height",
                          "line_W",  "force",   "moment",  "ticks", "low_W",        "high_W"}) {
    const std::string changed = with(std::string(key) + ":", std::string("x") + key + ":");
    EXPECT_THROW(load(changed), ConfigException) << key;
  }
  expectRefused(with("parking: true", "parking: true\ncolour: red"), 18, "unknown key colour");
  expectRefused(with("shape: solid", "shape: solid, bar_radius: 0.002"), 6, "unknown key objects/block/bar_radius");
}

TEST_F(LoadScene, WrongValuesAreRefusedWithTheirPlace) {
  expectRefused(with("urdf: scene.urdf", "urdf: gone.urdf"), 2, "there is no file");
  expectRefused(with("shape: round", "shape: oval"), 4, "expected one of: round, square, solid");
  expectRefused(with("inner_radius: 0.0075", "inner_radius: 0.0004"), 4, "objects/ring/inner_radius is 0.0004");
  expectRefused(with("inner_radius: 0.0075", "inner_radius: 7.5"), 4, "expected [0.0005, 0.05]");
  expectRefused(with("bar_radius: 0.002", "bar_radius: .nan"), 4, "objects/ring/bar_radius");
  expectRefused(with("base_W: [0.01, -0.02, 0.003]", "base_W: [0.01, -0.02]"), 8, "list of 3 numbers");
  expectRefused(with("base_W: [0.01,", "base_W: [1.01,"), 8, "pegs/a/base_W[0] is 1.01, expected [-1, 1]");
  expectRefused(with("height: 0.026", "height: -0.026"), 8, "pegs/a/height");
  expectRefused(with("force: 6.0", "force: 0.05"), 12, "force is 0.05, expected [0.1, 100]");
  expectRefused(with("moment: 0.06", "moment: 11"), 12, "expected [0.001, 10]");
  expectRefused(with("ticks: 5", "ticks: 0"), 12, "expected [1, 1000]");
  expectRefused(with("ticks: 5", "ticks: 2.5"), 12, "whole number");
  expectRefused(with("parking: true", "parking: 2"), 17, "true or false");
  expectRefused(with("tissue: [plate, dome]", "tissue: plate"), 13, "not a list");
  expectRefused(with("objects:\n  ring:", "objects:\n  Ring one:"), 4, "a name has 1 to 32");
  expectRefused(with("middle: [0.01, 0, 0.045]", "middle: [0.01, 0, x]"), 14, "not a number");
  expectRefused(with("high_W: [0.1, 0.2, 0.3]", "high_W: [0.1, -0.2, 0.3]"), 16, "high_W[1] is not above low_W");
}

TEST_F(LoadScene, WrongLinesOfWiresAreRefused) {
  const std::string line = "[[0, 0, 0], [0, 0.01, 0.02], [0.03, 0.01, 0.02]]";
  expectRefused(with(line, "[[0, 0, 0]]"), 10, "list of 2 to 64 points");
  expectRefused(with(line, "[[0, 0, 0], [0, 0.01]]"), 10, "line_W[1] is not a list of 3 numbers");
  expectRefused(with(line, "[[0, 0, 0], [0, 0.01, 2]]"), 10, "line_W[1][2] is 2");
  expectRefused(with(line, "[[0, 0, 0], [0, 0.01, 0], [0, 0.01, 0]]"), 10, "point 1 twice in a row");
  std::string many = "[";
  for (int i = 0; i < 65; ++i)
    many += "[0, 0, " + std::to_string(0.001 * i) + "], ";
  expectRefused(with(line, many + "]"), 10, "list of 2 to 64 points");
}

TEST_F(LoadScene, TwoRolesOfOneLinkAndTooManyPartsAreRefused) {
  expectRefused(with("link: frame_link", "link: ring_link"), 4, "names link ring_link twice");
  const std::string part = "  - {link: peg_a, force: 6.0, moment: 0.06, ticks: 5}\n";
  expectRefused(with(part, part + part), 12, "names link peg_a twice");
  std::string ten;
  for (int i = 0; i < 10; ++i)
    ten += "  - {link: peg_" + std::to_string(i) + ", force: 6.0, moment: 0.06, ticks: 5}\n";
  expectRefused(with(part, ten), 12, "has 13 entries, at most 12");  // with the three objects
}

TEST(Scenes, AllThatAreShippedLoad) {
  std::size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kFolder)) {
    const SceneRoles roles = loadScene(entry.path().string());
    EXPECT_FALSE(roles.title.empty());
    EXPECT_FALSE(roles.objects.empty()) << entry.path();
    EXPECT_FALSE(roles.tissue.empty()) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 1U);
}

/** config/load_scene.h: both limits of every number. */
TEST_F(LoadScene, BothLimitsOfEveryNumberHold) {
  for (const auto& [good, low, high, line] : std::vector<std::tuple<const char*, const char*, const char*, int>>{
           {"inner_radius: 0.0075", "inner_radius: 0.00049", "inner_radius: 0.0501", 4},
           {"bar_radius: 0.002}", "bar_radius: 0.00019}", "bar_radius: 0.0201}", 4},
           {"base_W: [0.01,", "base_W: [-1.01,", "base_W: [1.01,", 8},
           {"height: 0.026", "height: 0.0009", "height: 0.201", 8},
           {"radius: 0.004}", "radius: 0.00049}", "radius: 0.0501}", 8},
           {"radius: 0.00125", "radius: 0.00019", "radius: 0.0201", 10},
           {"[0.03, 0.01, 0.02]]", "[0.03, 0.01, -1.01]]", "[0.03, 0.01, 1.01]]", 10},
           {"force: 6.0", "force: 0.09", "force: 100.1", 12},
           {"moment: 0.06", "moment: 0.0009", "moment: 10.1", 12},
           {"ticks: 5", "ticks: 0", "ticks: 1001", 12},
           {"0.045]", "-1.01]", "1.01]", 14},
           {"low_W: [-0.1, -0.2, 0]", "low_W: [-1.01, -0.2, 0]", "low_W: [1.01, -0.2, 0]", 16},
           {"high_W: [0.1, 0.2, 0.3]", "high_W: [0.1, 0.2, -1.01]", "high_W: [0.1, 0.2, 1.01]", 16}}) {
    expectRefused(with(good, low), line, "expected [");
    expectRefused(with(good, high), line, "expected [");
  }
}

/** Along each axis, equal corners included. */
TEST_F(LoadScene, ABoxIsNotEmptyAlongAnyAxis) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (const char* low : {"0.35", "0.4"}) {
      std::array<std::string, 3> corner{"-0.1", "-0.2", "0"};
      corner[i] = low;
      const std::string lows = "low_W: [" + corner[0] + ", " + corner[1] + ", " + corner[2] + "]";
      expectRefused(with("low_W: [-0.1, -0.2, 0], high_W: [0.1, 0.2, 0.3]", lows + ", high_W: [0.35, 0.35, 0.35]"), 16,
                    "high_W[" + std::to_string(i) + "] is not above low_W");
    }
  }
}

/** kMaxSceneBodies is for objects and breakables together. */
TEST_F(LoadScene, ObjectsAndBreakablesShareThePlaces) {
  std::string breakables = "breakables:\n";
  for (std::size_t i = 0; i < kMaxSceneBodies; ++i)
    breakables += "  - {link: part_" + std::to_string(i) + ", force: 6.0, moment: 0.06, ticks: 5}\n";
  const std::string some = "breakables:\n  - {link: peg_a, force: 6.0, moment: 0.06, ticks: 5}\n";
  expectRefused(with(some, breakables), 12, "at most " + std::to_string(kMaxSceneBodies));
}

}  // namespace
}  // namespace raven2_trainer::config
