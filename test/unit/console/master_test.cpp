#include "raven2_trainer/console/master.h"

#include <gtest/gtest.h>

namespace raven2_trainer {
namespace {

TEST(WordsOfScale, AMasterOfAnotherScaleThanTheDaemonsIsTold) {
  MasterConfig master;
  master.name = "mtm";
  master.scale = 0.2;
  const std::string line = wordsOfScale(master, 0.1);
  EXPECT_EQ(line.find("WARNING: scale 0.2 of master mtm, but console.yaml has 0.1: "), 0U) << line;
  EXPECT_NE(line.find("--scale 0.2 are wrong by 2"), std::string::npos) << line;
  master.scale = 0.05;
  EXPECT_NE(wordsOfScale(master, 0.1).find("--scale 0.05 are wrong by 0.5"), std::string::npos);
  master.scale = 0.1;
  EXPECT_EQ(wordsOfScale(master, 0.1), "");
}

/** Two devices, each with its own topics. */
MasterConfig twoDevices() {
  MasterConfig master;
  master.reach = 0.35;
  for (const Arm arm : kArms) {
    const std::string name = deviceName(arm);
    at(master.devices, arm).pose = "/" + name + "/pose";
    at(master.devices, arm).operating_state = "/" + name + "/state";
  }
  return master;
}

/** Every trouble has a line, and the line has the trouble's figure in the unit that it names. */
struct Line {
  DeviceTrouble trouble;
  double value;  ///< [m], [rad], [s], [-]
  const char* part;
};
const Line kLines[] = {
    {DeviceTrouble::kNeverHeard, 0.0, "nothing has come on /DEVICE/pose "},
    {DeviceTrouble::kSilent, 0.2504, "nothing came on /DEVICE/pose for 250 ms"},
    {DeviceTrouble::kNoState, 0.0, "nothing has come on /DEVICE/state "},
    {DeviceTrouble::kNotReady, 0.0, "/DEVICE/state is not ENABLED and homed"},
    {DeviceTrouble::kLocked, 0.0, "locked"},
    {DeviceTrouble::kNotFinite, 0.0, "NaN or infinity"},
    {DeviceTrouble::kNotUnit, 0.5, "norm 0.5, not 1"},
    {DeviceTrouble::kMillimetres, 123.0, "positions of 123 m: "},
    {DeviceTrouble::kOutOfReach, 0.425, "0.425 m from the device's origin, which it cannot reach (reach: 0.35 m)"},
    {DeviceTrouble::kTooWide, 1.25, "through 1.25 m"},
    {DeviceTrouble::kMetres, 12e-6, "positions of 0.012 mm: "},
    {DeviceTrouble::kJump, 0.0215, "a jump of 21.5 mm "},
    {DeviceTrouble::kTurnJump, 1.5, "by 1.5 rad "},
    {DeviceTrouble::kNeverMoved, 0.0, "not changed since the start"},
    {DeviceTrouble::kFrozen, 3.25, "not changed for 3.2 s"},
    {DeviceTrouble::kTooSoon, 0.0, "not been looked at"},
    {DeviceTrouble::kRobotNotReady, 0.0, "the robot is not ready"},
};

TEST(Words, NameTheDeviceItsTopicAndTheFigureInItsUnit) {
  for (const Arm arm : kArms) {
    for (const Line& line : kLines) {
      std::string part = line.part;
      if (const auto at = part.find("DEVICE"); at != std::string::npos) part.replace(at, 6, deviceName(arm));
      const std::string text = words(twoDevices(), arm, {line.trouble, line.value});
      EXPECT_EQ(text.find(std::string(deviceName(arm)) + ": "), 0U) << text;
      EXPECT_NE(text.find(part), std::string::npos) << text;
    }
    EXPECT_EQ(words(twoDevices(), arm, {}), "");
  }
  EXPECT_STREQ(deviceName(Arm::kGold), "left");
  EXPECT_STREQ(deviceName(Arm::kGreen), "right");
}

}  // namespace
}  // namespace raven2_trainer
