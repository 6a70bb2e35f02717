#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "config/readers.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_impairment.h"
#include "raven2_trainer/config/load_master.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/yaml_file.h"

// Each packaged file states in a comment behind a key the range of its number: [unit] [low, high]. Both limits of
// every number must hold, and an error message must state them. A key without limits fails the test.

namespace raven2_trainer::config {
namespace {

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/";

struct Limits {
  double low{}, high{};
};

/** A number of a file, or a list of numbers. */
struct Leaf {
  std::string path;  ///< keys with '/' between them
  std::vector<std::string> values;
  bool is_list{};
  std::size_t line{};
};

struct Documented {
  const char* path;  ///< regular expression of FILE/KEY/...
  Limits limits;
};

/** Numbers whose line does not state their limits: several keys in one line, or limits that another key sets (here with
 *  its packaged value). The limits are stated above them in the file, or in doc/. */
const std::vector<Documented> kElsewhere{
    {"arms/tools/.*/d4", {-1.0, 0.0}},
    {"arms/tools/.*/lw", {0.001, 0.1}},
    {"arms/(limits/m..|home)", {-10.0, 10.0}},
    {"arms/rcm_W/.*", {-1.0, 1.0}},
    {"model/gains/.*", {0.0, 1e6}},
    {"model/(materials/.*|arm_give)/stiffness", {100.0, 1e8}},
    {"model/materials/.*/damping", {1.0, 1e6}},
    {"model/arm_give/damping", {0.0, 1e6}},
    {"model/arm_give/travel", {0.0, 0.01}},
    {"haptics/min_force|haptics/(guidance|edge)/max_force", {0.0, 3.3}},  // max_force
    {"haptics/max_slew", {25.0 * 3.3, 10000.0}},
    {"haptics/passivity/bank", {0.02, 10.0}},      // budget
    {"haptics/edge/margin", {0.001, 0.07 / 2.0}},  // half the shortest edge
    {"network/reconnect_max", {0.1, 60.0}},        // reconnect_min
    {"network/stale_after", {0.002, 0.044 - 3.3 / 140.0}},
    {"network/joy/(planning|simulation|trial|view|camera|tool_change|stop)", {-1.0, 127.0}},
    {"runtime/.*/priority", {0.0, 99.0}},
    {"runtime/.*/cpu", {-1.0, 1023.0}},
    {"crtk/move_speed", {0.001, 0.1}},     // max_speed
    {"crtk/move_turn_rate", {0.01, 2.0}},  // max_turn_rate
    {"render/trails/step", {8.0 / 400.0, 10.0}},
    {"render/live/slowest", {1.0, 120.0}},  // then fps: LoadConfig.TheLivePicturesBoundsAreChecked
    {"console/tremor_high", {8.0, 30.0}},   // tremor_low
    {"console/pause_max", {0.2, 10.0}},     // pause_min
    {"virtual_raven/.*(dac_clip|homing_dac)", {0.0, 32767.0}},
    {"virtual_raven/.*/max_inst_dac", {1.0, 32767.0}},
    {"virtual_raven/axes/.*/(transmission|(torque|counts)_per_amp)", {1e-6, 1e6}},  // divided by
    {"virtual_raven/(axes|training_levels)/.*", {0.0, 1e6}},
    {"detector/.*/inertia", {1e-7, 1.0}},
    {"detector/.*/(viscous|coulomb)", {0.0, 10.0}},
    {"detector/.*/offset", {-10.0, 10.0}},
    {"detector/.*/gravity", {-100.0, 100.0}},
    {"detector/.*/(published|departure)/.*", {0.0, 1e6}},
    {"plants/.*/torque_gain", {0.1, 10.0}},
    {"plants/.*/torque_offset", {-1.0, 1.0}},
    {"plants/.*/inertia", {1e-7, 1.0}},
    {"plants/.*/(coulomb|viscous)", {0.0, 10.0}},
    {"plants/.*/link_coulomb", {0.0, 1e3}},
    {"plants/.*/link_viscous", {0.0, 1e4}},
    {"plants/.*/cable_stiffness", {100.0, 1e12}},
    {"plants/.*/cable_damping", {0.0, 1e9}},
    {"masters/.*axes/.*", {-1.0, 1.0}},
    {"masters/.*/reading_closed", {-10.0, 10.0}},
    {"masters/.*/sticks", {0.0, 7.0}},
    {"masters/.*/gripper_input", {-1.0, 31.0}},
    {"masters/.*/pedal/silent_after", {0.0, 60.0}},  // of a pedal; 0 to 0.05 is refused with a different message
    {"impairments/.*/pause_s", {0.0, 86400.0}},
};

/** Keys that are not checked: joints are read in a loop, so the first and the last one are enough, each of one arm. */
const std::regex kAlike(
    "(axes|gains)/(elbow|insertion|tool_rotation|wrist|grasp1)/.*|gold/(elbow|insertion)/.*|"
    "green/(shoulder|elbow)/.*|training_levels/advanced/.*");

bool isNumber(const YAML::Node& node) {
  double value = 0.0;
  return node.IsScalar() && YAML::convert<double>::decode(node, value);
}

void collect(const YAML::Node& node, const std::string& path, std::vector<Leaf>* leaves) {
  if (node.IsMap()) {
    for (const auto& entry : node)
      collect(entry.second, path + (path.empty() ? "" : "/") + entry.first.Scalar(), leaves);
    return;
  }
  Leaf leaf{path, {}, node.IsSequence(), static_cast<std::size_t>(node.Mark().line)};
  if (isNumber(node)) leaf.values.push_back(node.Scalar());
  for (std::size_t i = 0; leaf.is_list && i < node.size() && isNumber(node[i]); ++i)
    leaf.values.push_back(node[i].Scalar());
  if (!leaf.values.empty() && !std::regex_match(path, kAlike)) leaves->push_back(leaf);
}

std::optional<double> numberOf(const std::string& text) {
  if (text == "pi") return kPi;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' ? std::optional<double>(value) : std::nullopt;
}

/** The first [low, high] of two numbers. */
std::optional<Limits> limitsIn(const std::string& text) {
  static const std::regex kPair("\\[([^\\[\\],]+), ([^\\[\\],]+)\\]");
  for (std::sregex_iterator i(text.begin(), text.end(), kPair), end; i != end; ++i) {
    const auto low = numberOf((*i)[1]), high = numberOf((*i)[2]);
    if (low && high) return Limits{*low, *high};
  }
  return std::nullopt;
}

std::optional<Limits> limitsOf(const std::string& file, const Leaf& leaf, const std::string& line) {
  for (const Documented& each : kElsewhere) {
    if (std::regex_match(file + "/" + leaf.path, std::regex(each.path))) return each.limits;
  }
  const std::size_t comment = line.find('#');
  return comment == std::string::npos ? std::nullopt : limitsIn(line.substr(comment));
}

std::string text(double value) {
  char digits[40];
  std::snprintf(digits, sizeof digits, "%.17g", value);
  return digits;
}

/** Loads a file's text with one value replaced. Returns the error message; empty: the text is accepted. */
using Say = std::function<std::string(const std::string& content, const Override& put)>;

class File {
 public:
  File(const std::string& name, Say say) : name_(name), say_(std::move(say)) {
    std::ifstream in(kFolder + name + ".yaml");
    std::stringstream all;
    all << in.rdbuf();
    content_ = all.str();
    for (std::string line; std::getline(all, line);)
      lines_.push_back(line);
  }

  /** @param[in] only checks the keys that match this regular expression. */
  void check(const std::string& only = ".*") const {
    std::vector<Leaf> leaves;
    collect(YAML::Load(content_), "", &leaves);
    EXPECT_FALSE(leaves.empty()) << name_;
    const std::regex wanted(only);
    for (const Leaf& leaf : leaves) {
      if (std::regex_match(leaf.path, wanted)) checkLeaf(leaf);
    }
  }

 private:
  void checkLeaf(const Leaf& leaf) const {
    const std::optional<Limits> limits = limitsOf(name_, leaf, lines_.at(leaf.line));
    if (!limits) {
      ADD_FAILURE() << name_ << ".yaml:" << leaf.line + 1 << ": no limits of " << leaf.path << " are stated";
      return;
    }
    const auto step = [](double bound) { return std::max(1e-9, 1e-4 * std::abs(bound)); };
    expectRefused(leaf, 0, limits->low - step(limits->low), *limits);
    expectRefused(leaf, leaf.values.size() - 1, limits->high + step(limits->high), *limits);
  }

  void expectRefused(const Leaf& leaf, std::size_t element, double value, const Limits& limits) const {
    std::vector<std::string> values = leaf.values;
    values[element] = text(value);
    std::string put = values[0];
    for (std::size_t i = 1; i < values.size(); ++i)
      put += ", " + values[i];
    const std::string said = say_(content_, {leaf.path, leaf.is_list ? "[" + put + "]" : put, "LIMITS"});
    const std::size_t place = said.find("expected [");
    const auto told = place == std::string::npos ? std::nullopt : limitsIn(said.substr(place));
    ASSERT_TRUE(told) << name_ << "/" << leaf.path << " takes " << value << "; " << said;
    EXPECT_NEAR(told->low, limits.low, 1e-5 * std::abs(limits.low)) << name_ << "/" << leaf.path << ": " << said;
    EXPECT_NEAR(told->high, limits.high, 1e-5 * std::abs(limits.high)) << name_ << "/" << leaf.path << ": " << said;
    const std::string key = leaf.path.substr(leaf.path.rfind('/') + 1);
    EXPECT_NE(said.find(key), std::string::npos) << said;
  }

  std::string name_, content_;
  Say say_;
  std::vector<std::string> lines_;
};

std::string messageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

template <typename Config>
Say by(void (*read)(Section&, Config*)) {
  return [read](const std::string& content, const Override& put) {
    return messageOf([&] {
      Section root = Section::fromText(content, "FILE");
      root.put(put);
      Config config{};
      read(root, &config);
      root.finish();
    });
  };
}

/** For configuration that is always read from a file. */
template <typename Load>
Say byFile(Load load) {
  return [load](const std::string& content, const Override& put) {
    Section root = Section::fromText(content, "FILE");
    root.put(put);
    const testing::TemporaryFile file("put.yaml", root.yaml());
    return messageOf([&] { load(file.path()); });
  };
}

void readNetworkAsPackaged(Section& root, NetworkConfig* c) {
  HapticGains haptics;
  haptics.max_force = 3.3;
  haptics.max_slew = 140.0;
  readNetwork(root, haptics, c);
}

TEST(Limits, OfEveryNumberOfTheDaemonsFilesHold) {
  File("arms", by(readArms)).check();
  File("model", by(readModel)).check();
  File("haptics", by(readHaptics)).check();
  File("network", by(readNetworkAsPackaged)).check();
  File("runtime", by(readRuntime)).check();
  File("planner", by(readPlanner)).check();
  File("execution", by(readExecution)).check();
  File("crtk", by(readCrtk)).check();
  File("render", by(readRender)).check();
  File("console", by(readConsole)).check();
}

TEST(Limits, OfEveryNumberOfTheRobotsFilesHold) {
  File("virtual_raven", by(readVirtualRaven)).check();
  File("detector", by(readDetector)).check();
  File("plants/identified", by(readPlant)).check();
}

TEST(Limits, OfEveryNumberOfMastersAndImpairmentsHold) {
  File("masters/touch_geomagic", byFile(loadMaster)).check();
  File("masters/gamepad", byFile(loadMaster)).check("stick_speed|dead_band|devices/.*");
  File("impairments/worst", byFile(loadImpairment)).check();
}

/** Numbers at their limits are accepted: the ranges include both ends. */
TEST(Limits, AreAllowedThemselves) {
  for (const double value : {-2.5, 0.0, 4.0}) {
    Section section = Section::fromText("x: " + text(value) + "\nwhole: " + text(value), "FILE");
    EXPECT_EQ(section.number("x", value, 5.0), value);
    EXPECT_EQ(section.number("x", -5.0, value), value);
    EXPECT_THROW(section.number("x", value + 1e-9, 5.0), ConfigException);
    EXPECT_THROW(section.number("x", -5.0, value - 1e-9), ConfigException);
  }
  Section whole = Section::fromText("x: 7", "FILE");
  EXPECT_EQ(whole.integer("x", 7, 9), 7);
  EXPECT_EQ(whole.integer("x", 5, 7), 7);
  EXPECT_THROW(whole.integer("x", 8, 9), ConfigException);
  EXPECT_THROW(whole.integer("x", 5, 6), ConfigException);
}

/** config/render.yaml, above the first camera. */
TEST(Limits, OfACameraHold) {
  const auto said = [](const std::string& piece, const std::string& bad) {
    std::ifstream in(kFolder + "render.yaml");
    std::stringstream all;
    all << in.rdbuf();
    return by(readRender)(testing::replaced(all.str(), piece, bad), {"video/fps", "30", "same"});
  };
  for (const auto& [piece, bad, range] : std::vector<std::array<const char*, 3>>{
           {"eye_W: [-0.94,", "eye_W: [-10.1,", "expected [-10, 10]"},
           {"eye_W: [-0.94,", "eye_W: [10.1,", "expected [-10, 10]"},
           {"target_W: [0.0, 0.0, 0.20]", "target_W: [0, 0, -10.1]", "expected [-10, 10]"},
           {"target_W: [0.0, 0.0, 0.20]", "target_W: [0, 0, 10.1]", "expected [-10, 10]"},
           {"up_W: [0, 0, 1]", "up_W: [0, 0, 1.1]", "expected [-1, 1]"},
           {"up_W: [0, 0, 1]", "up_W: [0, 0, -1.1]", "expected [-1, 1]"},
           {"vertical_fov: 0.6", "vertical_fov: 0.09", "expected [0.1, 2]"},
           {"vertical_fov: 0.6", "vertical_fov: 2.1", "expected [0.1, 2]"}}) {
    EXPECT_NE(said(piece, bad).find(range), std::string::npos) << bad << ": " << said(piece, bad);
  }
}

}  // namespace
}  // namespace raven2_trainer::config
