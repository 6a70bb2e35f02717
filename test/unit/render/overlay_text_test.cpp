#include "render/overlay_text.h"

#include <gtest/gtest.h>

namespace raven2_trainer::render {
namespace {

HapticGains gains() {
  HapticGains haptics;
  haptics.tolerance = 0.003;
  haptics.max_force = 3.3;
  return haptics;
}

Snapshot teleoperating() {
  Snapshot s;
  s.model.session_tick = 12'345;
  s.model.mode = Mode::kTeleoperating;
  s.model.pedal = 1;
  s.model.robot_fresh = 1;
  s.robot.frame = 10;
  s.robot.runlevel = RunLevel::kPedalDown;
  s.model.arms[0].p_BT = {0.01, 0.02, 0.03};
  s.robot.arms[0].p_BT = {0.01, 0.02 + 0.003, 0.03 - 0.004};  // 3-4-5: 5 mm apart
  s.haptic.force_B[1] = {0.0, -1.2, 1.6};                     // 2 N
  return s;
}

bool hasLine(const Overlay& overlay, const std::string& first, const std::string& second) {
  for (const std::string& line : overlay.lines) {
    if (line.find(first) == 0 && line.find(second) != std::string::npos) return true;
  }
  return false;
}

TEST(OverlayText, SaysTimeModeRunLevelPedalAndErrors) {
  const Overlay overlay = describe(teleoperating(), gains());
  EXPECT_TRUE(hasLine(overlay, "time", "12.345 s"));
  EXPECT_TRUE(hasLine(overlay, "mode", "teleoperating"));
  EXPECT_TRUE(hasLine(overlay, "robot", "PEDAL_DN"));
  EXPECT_TRUE(hasLine(overlay, "pedal", "down"));
  EXPECT_TRUE(hasLine(overlay, "gold", " 5.00 mm"));
  EXPECT_TRUE(hasLine(overlay, "green", " 0.00 mm"));
}

TEST(OverlayText, ForcesAreTheNormsOfTheCue) {
  const Overlay overlay = describe(teleoperating(), gains());
  EXPECT_DOUBLE_EQ(overlay.force[0], 0.0);
  EXPECT_NEAR(overlay.force[1], 2.0, 1e-12);
  EXPECT_EQ(overlay.max_force, 3.3);
}

TEST(OverlayText, TheBannerNamesTheFaultWhileItActs) {
  Snapshot s = teleoperating();
  EXPECT_EQ(describe(s, gains()).banner, "");
  s.fault = "sudden_jump";
  EXPECT_EQ(describe(s, gains()).banner, "FAULT: sudden_jump");
}

TEST(OverlayText, AStaleRobotAndADisengagedOneAreMarked) {
  Snapshot s = teleoperating();
  s.model.robot_fresh = 0;
  s.model.engaged = 0;
  EXPECT_TRUE(hasLine(describe(s, gains()), "robot", "STALE"));
  EXPECT_TRUE(hasLine(describe(s, gains()), "pedal", "disengaged"));
}

TEST(OverlayText, AVirtualPictureThatStandsInForTheCamerasSaysSo) {
  Snapshot s = teleoperating();
  EXPECT_FALSE(hasLine(describe(s, gains()), "camera", ""));
  s.stands_in = true;
  EXPECT_TRUE(hasLine(describe(s, gains()), "camera", "STALE"));
}

TEST(OverlayText, WithoutARobotThereIsNoError) {
  Snapshot s = teleoperating();
  s.robot.frame = 0;
  const Overlay overlay = describe(s, gains());
  EXPECT_TRUE(hasLine(overlay, "robot", "none"));
  EXPECT_FALSE(hasLine(overlay, "gold", "mm"));
}

TEST(OverlayText, ValuesThatNoLogShouldHoldDoNoHarm) {
  Snapshot s = teleoperating();
  s.model.mode = static_cast<Mode>(200);
  s.robot.runlevel = static_cast<RunLevel>(200);
  s.model.session_tick = std::int64_t{1} << 62;
  s.robot.arms[0].p_BT = {1e300, 0.0, 0.0};
  const Overlay overlay = describe(s, gains());
  EXPECT_TRUE(hasLine(overlay, "mode", "?"));
  for (const std::string& line : overlay.lines)
    EXPECT_LT(line.size(), 100U);
}

}  // namespace
}  // namespace raven2_trainer::render
