#include "raven2_trainer/config/load_master.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "config/named_files.h"
#include "support/yaml_file.h"

namespace raven2_trainer::config {
namespace {

using testing::expectEachRefused;
using testing::expectRefused;
using testing::replaced;

const std::string kFolder = RAVEN2_TRAINER_SOURCE_DIR "/config/masters";

void load(const std::string& text) {
  const testing::TemporaryFile file("master.yaml", text);
  loadMaster(file.path());
}

/** Line n of a text has n as its number. */
const std::string kGood = R"(meaning: a test
family: crtk
scale: 0.2
units: mm
axes:
  forward: [0, 0, -1]
  right: [1, 0, 0]
  down: [0, -1, 0]
orientation: true
turn_axes: {forward: [1, 0, 0], right: [0, 1, 0], down: [0, 0, 1]}
workspace: [0.16, 0.12, 0.07]
reach: 0.5
max_speed: 3.0
max_jump: 0.005
max_turn_rate: 30.0
max_turn_jump: 0.2
watch: 0.5
silent_after: 0.1
frozen_after: 2.0
force: {max: 3.3, per_newton: 1.0, rate: 500}
pedal: {from: any, button: 0, topic: "", silent_after: 0.5}
gripper: {from: button_toggles, open: 0.6, closed: 0.0, speed: 3.0, reading_open: 1.0, reading_closed: 0.0}
devices:
  right:
    pose: /right/measured_cp
    buttons: [/right/button1, /right/button2]
    gripper: ""
    operating_state: ""
    force: /right/servo_cf
    force_absolute: ""
    gravity_compensation: ""
    gripper_input: 1
)";

TEST(LoadMaster, EveryShippedFileIsGood) {
  const std::vector<std::string> names = namesIn(kFolder);
  EXPECT_EQ(names, (std::vector<std::string>{"browser", "crtk_pair", "gamepad", "mtm", "omni", "omni_pair",
                                             "touch_geomagic"}));
  for (const std::string& name : names) {
    const MasterConfig master = findMaster(kFolder, name);
    EXPECT_EQ(master.name, name);
    EXPECT_EQ(master.devices[0].is_used, true) << name;
    EXPECT_EQ(master.devices[1].is_used, name != "omni" && name != "touch_geomagic") << name;
  }
}

TEST(LoadMaster, ValuesArriveInMetresAndArms) {
  const testing::TemporaryFile file("mine.yaml", kGood);
  const MasterConfig master = findMaster(kFolder, file.path());
  EXPECT_EQ(master.name, "mine");
  EXPECT_EQ(master.family, DeviceFamily::kCrtk);
  EXPECT_EQ(master.metres_per_unit, 1e-3);
  EXPECT_EQ(master.axes[0], (Vec3{0, 0, -1}));
  EXPECT_EQ(master.axes[2], (Vec3{0, -1, 0}));
  EXPECT_FALSE(master.devices[0].is_used);
  const DeviceTopics& right = master.devices[1];
  EXPECT_EQ(right.pose, "/right/measured_cp");
  EXPECT_EQ(right.buttons.size(), 2U);
  EXPECT_EQ(right.force, "/right/servo_cf");
  EXPECT_EQ(right.gripper_input, 1);
  EXPECT_EQ(right.gravity_compensation, "");
  EXPECT_EQ(findMaster(kFolder, "mtm").devices[1].gravity_compensation, "/MTMR/use_gravity_compensation");
  EXPECT_EQ(master.pedal_silent_after, 0.5);
  EXPECT_EQ(findMaster(kFolder, "mtm").pedal_silent_after, 0.0);
  EXPECT_EQ(master.max_force, 3.3);
  EXPECT_EQ(master.force_rate, 500.0);
  EXPECT_EQ(master.gripper_from, GripperFrom::kToggles);
  EXPECT_EQ(findMaster(kFolder, "gamepad").devices[1].sticks, (std::array<int, 3>{3, 4, 6}));
}

TEST(LoadMaster, WhatIsWrongIsNamedWithItsLine) {
  ASSERT_NO_THROW(load(kGood));
  expectEachRefused(load, kGood,
                    {{"family: crtk", "family: falcon", 2},
                     {"scale: 0.2", "scale: 2.0", 3},
                     {"units: mm", "units: cm", 4},
                     {"forward: [0, 0, -1]", "forward: [0, 0, 0]", 6},
                     {"forward: [0, 0, -1]", "forward: [1, 0, 0]", 6},
                     {"forward: [0, 0, -1]", "forward: [0, 0, -0.5]", 6},
                     {"forward: [0, 0, -1]", "forward: [0, 0, 1]", 6},
                     {"orientation: true", "orientation: maybe", 9},
                     {"reach: 0.5", "reach: 500", 12},
                     {"max_turn_rate: 30.0", "max_turn_rate: 0.0", 15},
                     {"max_turn_jump: 0.2", "max_turn_jump: 4.0", 16},
                     {"rate: 500", "rate: 5000", 20},
                     {"from: any", "from: foot", 21},
                     {"from: any", "from: left", 21},
                     {"from: any", "from: topic", 21},
                     {"silent_after: 0.5", "silent_after: 0.01", 21},
                     {"silent_after: 0.5", "silent_after: 61.0", 21},
                     {"from: button_toggles", "from: axis", 22},
                     {"from: button_toggles", "from: joint", 27},
                     {"open: 0.6", "open: -0.1", 22},
                     {"open: 0.6", "open: 0.0", 22},  // as closed
                     {"reading_open: 1.0", "reading_open: 0.0", 22},
                     {"pose: /right/measured_cp", "pose: \"\"", 25},
                     {"pose: /right/measured_cp", "pose: /right//measured_cp", 25},
                     {"pose: /right/measured_cp", "pose: ~measured_cp", 25},
                     {"/right/button2]", "right button]", 26},
                     {"force: /right/servo_cf", "force: 9", 29},
                     {"gripper_input: 1", "gripper_input: 99", 32},
                     {"  right:\n    pose", "  middle:\n    pose", 24}});
}

TEST(LoadMaster, KeysOfAnotherFamilyAndMissingOnesAreRefused) {
  expectRefused(load, replaced(kGood, "family: crtk", "family: joy"), 1, "stick_speed is missing");
  expectRefused(load, replaced(kGood, "watch: 0.5\n", ""), 1, "watch is missing");
  expectRefused(load, kGood + "stick_speed: 0.1\n", 33, "unknown key");
  expectRefused(load, replaced(kGood, "buttons: [/right/button1, /right/button2]", "buttons: []"), 24, "no buttons");
  expectRefused(load, replaced(kGood, "gripper_input: 1", "gripper_input: -1"), 24, "no gripper_input");
}

TEST(LoadMaster, AnUnknownNameListsTheKnownOnes) {
  try {
    findMaster(kFolder, "falcon");
    FAIL();
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("omni_pair"), std::string::npos) << e.what();
  }
}

/** As kGood, with the one device on the other side. */
std::string onTheLeft(const std::string& text) {
  return replaced(text, "  right:\n", "  left:\n");
}

/** The pedal of one hand needs that hand's device, and a button on it. */
TEST(LoadMaster, ThePedalIsOfADeviceThatIsThereAndHasButtons) {
  const std::string right = replaced(kGood, "from: any", "from: right");
  const std::string left = replaced(kGood, "from: any", "from: left");
  EXPECT_NO_THROW(load(right));
  EXPECT_NO_THROW(load(onTheLeft(left)));
  expectRefused(load, onTheLeft(right), 21, "of a device that is not there");
  expectRefused(load, left, 21, "of a device that is not there");
  const auto bare = [](std::string text) {
    text = replaced(text, "from: button_toggles", "from: none");
    return replaced(text, "buttons: [/right/button1, /right/button2]", "buttons: []");
  };
  expectRefused(load, bare(right), 24, "right has no buttons");
  expectRefused(load, bare(onTheLeft(left)), 24, "left has no buttons");
}

/** Several topics are one button each; one topic may carry any number. */
TEST(LoadMaster, AButtonThatTheTopicsDoNotHaveIsRefused) {
  const std::string far_pedal = replaced(kGood, "button: 0", "button: 2");
  expectRefused(load, far_pedal, 21, "pedal is button 2, but right has 2 topics of buttons, 0 to 1");
  expectRefused(load, onTheLeft(far_pedal), 21, "but left has 2 topics");
  const std::string far_jaws = replaced(kGood, "gripper_input: 1", "gripper_input: 2");
  expectRefused(load, far_jaws, 22, "gripper is button 2, but right has 2 topics of buttons");
  const auto oneTopic = [](const std::string& text) {
    return replaced(text, "[/right/button1, /right/button2]", "[/right/buttons]");
  };
  EXPECT_NO_THROW(load(oneTopic(far_pedal)));
  EXPECT_NO_THROW(load(oneTopic(far_jaws)));
  EXPECT_NO_THROW(load(replaced(replaced(far_pedal, "from: any", "from: topic"), "topic: \"\"", "topic: /pedal")));
}

/** Each of the three directions takes another axis of the device. */
TEST(LoadMaster, NoAxisIsUsedTwiceAndNoneIsMirrored) {
  for (const auto& [good, bad] : std::vector<std::pair<const char*, const char*>>{
           {"right: [1, 0, 0]\n", "right: [0, 1, 0]\n"}, {"down: [0, -1, 0]\n", "down: [1, 0, 0]\n"},
           {"right: [1, 0, 0]\n", "right: [0, 0, 1]\n"}})
    expectRefused(load, replaced(kGood, good, bad), 6, "none twice");
  for (const auto& [good, bad] : std::vector<std::pair<const char*, const char*>>{
           {"right: [1, 0, 0]\n", "right: [-1, 0, 0]\n"}, {"down: [0, -1, 0]\n", "down: [0, 1, 0]\n"}})
    expectRefused(load, replaced(kGood, good, bad), 6, "mirrors");
}

}  // namespace
}  // namespace raven2_trainer::config
