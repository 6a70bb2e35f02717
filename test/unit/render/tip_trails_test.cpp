#include "render/tip_trails.h"

#include <gtest/gtest.h>

#include <limits>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ArmGeometry geometry() {
  ArmGeometry g;
  g.d4 = -0.47;
  g.lw = 0.013;
  g.home = {0.5, 1.6, 0.40, 0.0, 0.0, 0.8, 0.8};
  return g;
}

/** Trails with both bases at the origin and along W, so that a tip has the same place in W and B. */
TipTrails trails(double duration = 1.0, double step = 0.05) {
  return TipTrails(geometry(), {}, TrailConfig{duration, step});
}

/** The gold tip goes along x at this speed [m/s] from tick 0 on; the green one stays at y = 1 m. */
Snapshot at(Tick tick, double speed, Mode mode = Mode::kPedalUp) {
  Snapshot s;
  s.model.tick = tick;
  s.model.mode = mode;
  s.model.arms[0].p_BT = {speed * static_cast<double>(tick) * kTickSeconds, 0.0, 0.0};
  s.model.arms[1].p_BT = {0.0, 1.0, 0.0};
  for (ArmState& arm : s.model.arms)
    arm.q_d = geometry().home;
  return s;
}

std::vector<double> goldPlaces(const TipTrails& t) {
  std::vector<double> places;
  for (const Vector3& mark : t.marks(Trail::kTrack)) {
    if (mark.y() < 0.5) places.push_back(mark.x());
  }
  return places;
}

TEST(TipTrails, MarksStandAtEqualTimesWhateverTheRateOfFrames) {
  for (const Tick period : {1, 7, 33, 50, 100, 240}) {
    TipTrails t = trails(10.0);
    for (Tick tick = 0; tick <= 960; tick += period)
      t.follow(at(tick, 0.2));
    const std::vector<double> places = goldPlaces(t);
    const Tick last = 960 / period * period;
    ASSERT_EQ(places.size(), static_cast<std::size_t>(last / 50)) << period;
    for (std::size_t i = 0; i < places.size(); ++i)
      EXPECT_NEAR(places[i], 0.2 * 0.05 * static_cast<double>(i + 1), 1e-12) << period;
  }
}

TEST(TipTrails, OlderMarksAreForgotten) {
  TipTrails t = trails(0.5);
  for (Tick tick = 0; tick <= 100'000; tick += 25)
    t.follow(at(tick, 0.01));
  const std::vector<double> places = goldPlaces(t);
  ASSERT_EQ(places.size(), 10U);
  EXPECT_NEAR(places.front(), 0.01 * (100.0 - 0.45), 1e-9);
}

TEST(TipTrails, OldMarksOfBothArmsAreForgottenTogether) {
  TipTrails t = trails(0.5);
  for (Tick tick = 0; tick <= 1000; tick += 100)
    t.follow(at(tick, 0.1));
  t.follow(at(1050, 0.1));
  EXPECT_EQ(goldPlaces(t).size(), 10U);
  EXPECT_EQ(t.marks(Trail::kTrack).size(), 2 * 10U);
}

TEST(TipTrails, AsManyAreKeptWhetherOneFollowsAllOrTheLastSecondsOnly) {
  TipTrails all = trails(1.0), late = trails(1.0);
  for (Tick tick = 0; tick <= 5000; tick += 33) {
    all.follow(at(tick, 0.1));
    if (tick >= 3800) late.follow(at(tick, 0.1));
  }
  EXPECT_EQ(goldPlaces(all), goldPlaces(late));
}

TEST(TipTrails, TheHandsAndThePlansTargetsAreToldApart) {
  const Vector3 target = kinematics::forward(geometry(), Arm::kGold, geometry().home).p;
  TipTrails t = trails(10.0);
  for (Tick tick = 0; tick <= 200; tick += 10)
    t.follow(at(tick, 0.1, Mode::kTeleoperating));
  EXPECT_EQ(t.marks(Trail::kUser).size(), 2 * 4U) << "the trails of both hands";
  EXPECT_TRUE(t.marks(Trail::kPlan).empty());
  EXPECT_LT((t.marks(Trail::kUser)[0] - target).norm(), 1e-12);
  for (Tick tick = 210; tick <= 400; tick += 10) {
    Snapshot s = at(tick, 0.1, Mode::kExecuting);
    s.model.planning.arm = Arm::kGold;
    t.follow(s);
  }
  EXPECT_EQ(t.marks(Trail::kUser).size(), 2 * 4U);
  EXPECT_EQ(t.marks(Trail::kPlan).size(), 4U) << "the trail of the plan's arm, from the first whole step";
  for (Tick tick = 410; tick <= 600; tick += 10)
    t.follow(at(tick, 0.1, Mode::kPedalUp));
  EXPECT_EQ(t.marks(Trail::kPlan).size(), 4U) << "with the pedal up there is no target";
  EXPECT_EQ(t.marks(Trail::kTrack).size(), 2 * 12U);
}

/** The step at 250 ms lies between the last picture of the one and the first of the other. */
TEST(TipTrails, BetweenTheHandsTargetAndThePlansThereIsNone) {
  TipTrails t = trails(10.0);
  for (Tick tick = 0; tick <= 400; tick += 20) {
    Snapshot s = at(tick, 0.1, tick <= 240 ? Mode::kTeleoperating : Mode::kExecuting);
    s.model.planning.arm = Arm::kGreen;
    t.follow(s);
  }
  EXPECT_EQ(t.marks(Trail::kUser).size(), 2 * 4U);
  EXPECT_EQ(t.marks(Trail::kPlan).size(), 3U);
  EXPECT_EQ(t.marks(Trail::kTrack).size(), 2 * 8U);
}

TEST(TipTrails, NothingIsMarkedBetweenFramesThatLieFarApart) {
  TipTrails t = trails(10.0);
  t.follow(at(0, 0.1));
  t.follow(at(1000, 0.1));
  EXPECT_TRUE(t.marks(Trail::kTrack).empty());
  t.follow(at(1100, 0.1));
  EXPECT_EQ(goldPlaces(t).size(), 2U);
}

TEST(TipTrails, AnOlderTickBeginsAnewAndTheSameOneChangesNothing) {
  TipTrails t = trails(10.0);
  for (const Tick tick : {0, 100, 100, 200})
    t.follow(at(tick, 0.1));
  EXPECT_EQ(goldPlaces(t).size(), 4U);
  t.follow(at(50, 0.1));
  EXPECT_TRUE(goldPlaces(t).empty());
  t.follow(at(100, 0.1));
  EXPECT_EQ(goldPlaces(t).size(), 1U);
}

TEST(TipTrails, WhatIsNotFiniteLeavesNoMark) {
  TipTrails t = trails(10.0);
  for (Tick tick = 0; tick <= 500; tick += 50) {
    Snapshot s = at(tick, 0.1, Mode::kTeleoperating);
    if (tick >= 200 && tick < 350) s.model.arms[0].p_BT[2] = s.model.arms[0].q_d[kElbow] = kNan;
    t.follow(s);
  }
  for (const Trail trail : {Trail::kUser, Trail::kPlan, Trail::kTrack}) {
    for (const Vector3& mark : t.marks(trail))
      EXPECT_TRUE(mark.allFinite());
  }
  EXPECT_EQ(goldPlaces(t).size(), 10U - 4U) << "missing: three ticks, and the step back from the last";
}

}  // namespace
}  // namespace raven2_trainer::render
