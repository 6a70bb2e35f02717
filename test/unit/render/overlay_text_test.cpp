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

TEST(OverlayText, TheBriefLinesSayModeAndExercise) {
  Snapshot s = teleoperating();
  EXPECT_EQ(describe(s, gains()).brief, std::vector<std::string>{"teleoperating"});
  s.model.robot_fresh = 0;
  s.model.exercise.status = ExerciseStatus::kWaiting;
  EXPECT_EQ(describe(s, gains()).brief,
            (std::vector<std::string>{"teleoperating, robot STALE", "waiting, 0 s, 0 mistakes"}));
  EXPECT_TRUE(describe(s, SceneOptions(gains(), OverlaySet())).brief.empty());
}

TEST(OverlayText, AVirtualPictureThatStandsInForTheCamerasSaysSo) {
  Snapshot s = teleoperating();
  EXPECT_FALSE(hasLine(describe(s, gains()), "camera", ""));
  s.is_substitute = true;
  EXPECT_TRUE(hasLine(describe(s, gains()), "camera", "STALE"));
}

TEST(OverlayText, WithoutARobotThereIsNoError) {
  Snapshot s = teleoperating();
  s.robot.frame = 0;
  const Overlay overlay = describe(s, gains());
  EXPECT_TRUE(hasLine(overlay, "robot", "none"));
  EXPECT_FALSE(hasLine(overlay, "gold", "mm"));
}

TEST(OverlayText, TheAgeOfTheRobotsStateIsToldAndStaleBeyondItsLimit) {
  Snapshot s = teleoperating();
  s.model.time_ns = 2'000'000'000;
  s.robot.received_ns = s.model.time_ns - 3'400'000;
  EXPECT_TRUE(hasLine(describe(s, gains()), "latency", " 3.4 ms"));
  EXPECT_FALSE(hasLine(describe(s, gains()), "latency", "STALE"));
  s.robot.received_ns = s.model.time_ns - 20'100'000;
  EXPECT_TRUE(hasLine(describe(s, gains()), "latency", " 20.1 ms STALE"));
  s.robot.frame = 0;
  EXPECT_FALSE(hasLine(describe(s, gains()), "latency", "ms")) << "without a robot's frame there is no latency";
}

TEST(OverlayText, TheTimerTellsStepTimeMistakesAndHowItEnded) {
  SceneOptions options(gains());
  options.exercise_steps = 12;
  Snapshot s = teleoperating();
  EXPECT_FALSE(hasLine(describe(s, options), "exercise", "")) << "the session has no exercise";
  s.model.tick = 20'000;
  s.model.exercise.status = ExerciseStatus::kRunning;
  s.model.exercise.step = 3;
  s.model.exercise.began = 7'500;
  s.model.exercise.mistakes = {1, 0, 2, 0, 0, 0};
  EXPECT_TRUE(hasLine(describe(s, options), "exercise", "step 3 of 12"));
  EXPECT_TRUE(hasLine(describe(s, options), "  ", "12.5 s, 3 mistakes"));
  s.model.exercise.status = ExerciseStatus::kDone;
  s.model.exercise.step = 13;
  s.model.exercise.ended = 17'500;
  s.model.exercise.mistakes = {1, 0, 0, 0, 0, 0};
  EXPECT_TRUE(hasLine(describe(s, options), "exercise", "done"));
  EXPECT_TRUE(hasLine(describe(s, options), "  ", "10.0 s, 1 mistake")) << "the timer has stopped";
  s.verdict.passed = false;
  s.verdict.composite = 0.857;
  EXPECT_TRUE(hasLine(describe(s, options), "exercise", "done, not passed, score 86 %"));
  EXPECT_EQ(describe(s, options).banner, "") << "an exercise that is done has not failed";
  s.model.exercise.status = ExerciseStatus::kRunning;
  EXPECT_FALSE(hasLine(describe(s, options), "exercise", "score")) << "no score before the end";
  s.verdict = {};
  s.model.exercise.status = ExerciseStatus::kFailed;
  s.model.exercise.failure = ExerciseFailure::kTimeLimit;
  EXPECT_TRUE(hasLine(describe(s, options), "exercise", "failed: time limit"));
  EXPECT_EQ(describe(s, options).banner, "ATTEMPT FAILED: time limit");
  s.fault = "sudden_jump";
  EXPECT_NE(describe(s, options).banner.find("sudden_jump"), std::string::npos)
      << "the banner shows an active fault first";
  s.fault.clear();
  s.model.exercise.began = -1;
  EXPECT_TRUE(hasLine(describe(s, options), "  ", "not begun, 1 mistake"));
  s.model.exercise.status = static_cast<ExerciseStatus>(99);
  s.model.exercise.began = -(std::int64_t{1} << 62);
  EXPECT_TRUE(hasLine(describe(s, options), "exercise", "?"));
}

TEST(OverlayText, EachPartStandsUnderItsName) {
  Snapshot s = teleoperating();
  s.fault = "sudden_jump";
  s.model.exercise.status = ExerciseStatus::kWaiting;
  const auto only = [&](OverlayKind kind) {
    OverlaySet set;
    set.add(kind);
    return describe(s, SceneOptions(gains(), set));
  };
  const Overlay none = describe(s, SceneOptions(gains(), OverlaySet()));
  EXPECT_TRUE(none.lines.empty() && none.banner.empty() && !none.has_bars);
  EXPECT_EQ(only(OverlayKind::kStatus).lines.size(), 6U);
  EXPECT_EQ(only(OverlayKind::kLatency).lines.size(), 1U);
  EXPECT_EQ(only(OverlayKind::kTimer).lines.size(), 2U);
  EXPECT_TRUE(only(OverlayKind::kForceBars).has_bars);
  EXPECT_EQ(only(OverlayKind::kHazard).banner, "FAULT: sudden_jump");
  EXPECT_TRUE(only(OverlayKind::kStatus).banner.empty()) << "the trainee must not read the fault's name";
  s.is_substitute = true;
  EXPECT_TRUE(hasLine(describe(s, SceneOptions(gains(), OverlaySet())), "camera", "STALE"))
      << "whatever overlays are chosen";
}

TEST(OverlayText, TheBannerSaysWhatAFaultDoesToTheTraineesPicture) {
  Snapshot s = teleoperating();
  s.fault = "video_freeze";
  const auto set = [&s](PictureFault fault) { s.model.faults.picture = static_cast<std::uint8_t>(fault); };
  set(PictureFault::kFrozen);
  EXPECT_EQ(describe(s, gains()).banner, "FAULT: video_freeze, picture frozen");
  set(PictureFault::kBlack);
  EXPECT_EQ(describe(s, gains()).banner, "FAULT: video_freeze, picture black");
  set(PictureFault::kEyesSwapped);
  EXPECT_EQ(describe(s, gains()).banner, "FAULT: video_freeze, eyes swapped");
  set(static_cast<PictureFault>(200));
  EXPECT_EQ(describe(s, gains()).banner, "FAULT: video_freeze") << "an intact log has no such value";
  set(PictureFault::kNone);
  s.model.faults.picture_delay_ms = 500;
  EXPECT_EQ(describe(s, gains()).banner, "FAULT: video_freeze, picture 500 ms late");
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
