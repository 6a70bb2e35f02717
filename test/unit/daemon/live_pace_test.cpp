#include "raven2_trainer/daemon/live_pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace raven2_trainer::daemon {
namespace {

RenderConfig configured(int fps = 30, int slowest = 10, double smallest = 0.5, double settle = 3.0) {
  RenderConfig config;
  config.live_fps = fps;
  config.live_slowest = slowest;
  config.live_smallest = smallest;
  config.live_settle = settle;
  return config;
}

/** [s] of a frame at a level, `time` [s] after the start. */
using Load = std::function<double(const LiveLevel& level, double time)>;

/** Drawing takes `whole` [s] for a whole picture; a tenth of that time does not depend on the size. */
Load byPixels(double whole) {
  return [whole](const LiveLevel& level, double) { return whole * (0.1 + 0.9 * level.scale * level.scale); };
}

struct Change {
  double time;
  std::uint32_t level;
};

std::vector<Change> run(LivePace* pace, const Load& load, double seconds) {
  std::vector<Change> changes;
  for (double time = 0.0; time < seconds;) {
    const double busy = load(pace->level(), time);
    time += std::max(busy, pace->period());
    if (pace->add(busy)) changes.push_back({time, pace->lowered()});
  }
  return changes;
}

TEST(LivePace, FirstTheSizeThenTheRate) {
  const LivePace pace(configured());
  const std::vector<LiveLevel>& levels = pace.levels();
  ASSERT_EQ(levels.size(), 6U);
  const std::vector<int> rates{30, 30, 30, 20, 15, 10};
  const std::vector<double> scales{1.0, 0.75, 0.5, 0.5, 0.5, 0.5};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    EXPECT_EQ(levels[i].fps, rates[i]) << i;
    EXPECT_DOUBLE_EQ(levels[i].scale, scales[i]) << i;
  }
  EXPECT_EQ(pace.level().fps, 30);
}

TEST(LivePace, TheConfigurationsBoundsAreKept) {
  const auto rates = [](const LivePace& pace) {
    std::vector<int> all;
    for (const LiveLevel& level : pace.levels())
      all.push_back(level.fps);
    return all;
  };
  EXPECT_EQ(rates(LivePace(configured(25, 15, 1.0))), (std::vector<int>{25, 20, 15}));
  EXPECT_EQ(rates(LivePace(configured(8, 10, 0.75))), (std::vector<int>{8, 8})) << "no rate is above the configured";
  LivePace fixed(configured(30, 30, 1.0));
  EXPECT_TRUE(run(&fixed, byPixels(10.0), 300.0).empty());
  EXPECT_EQ(fixed.levels().size(), 1U);
}

TEST(LivePace, FramesInTimeChangeNothing) {
  LivePace pace(configured());
  EXPECT_TRUE(run(&pace, byPixels(0.033), 60.0).empty());
}

TEST(LivePace, ItGoesDownAsFarAsFramesNeedAndNoFurther) {
  // [s] a whole picture takes, and the level at which it fits: 0.606 of it at 3/4, 0.325 of it at 1/2, by the
  // periods 33, 50, 67, 100 ms.
  const std::vector<std::pair<double, std::uint32_t>> cases{{0.032, 0}, {0.036, 1}, {0.054, 1}, {0.060, 2}, {0.101, 2},
                                                            {0.110, 3}, {0.160, 4}, {0.220, 5}, {3.0, 5}};
  for (const auto& [whole, level] : cases) {
    LivePace pace(configured());
    const std::vector<Change> changes = run(&pace, byPixels(whole), 120.0);
    EXPECT_EQ(pace.lowered(), level) << whole;
    EXPECT_EQ(changes.size(), level) << whole << ": each step once, no step back";
  }
}

TEST(LivePace, ASlowFrameNowAndThenIsNoReason) {
  LivePace pace(configured());
  int n = 0;
  const Load hiccups = [&n](const LiveLevel&, double) { return ++n % 10 == 0 ? 0.2 : 0.01; };
  EXPECT_TRUE(run(&pace, hiccups, 60.0).empty());
  LivePace first(configured());
  const Load compiles = [](const LiveLevel&, double time) { return time == 0.0 ? 2.0 : 0.01; };
  EXPECT_TRUE(run(&first, compiles, 10.0).empty()) << "shaders are compiled in the first frame";
}

/** Of five frames one is late. [s] It takes `late` of a whole picture, the others fit. */
Load oneInFive(double late) {
  int n = 0;
  return [late, n](const LiveLevel& level, double time) mutable {
    return byPixels(++n % 5 == 0 ? late : 0.025)(level, time);
  };
}

/** Where the half of them fits, the rate would be kept: but the picture that a hand follows is late. */
TEST(LivePace, TheSizeGoesDownWhereOneFrameInFiveIsLate) {
  LivePace pace(configured());
  EXPECT_EQ(run(&pace, oneInFive(0.06), 60.0).size(), 1U);
  EXPECT_EQ(pace.lowered(), 1U) << "36 ms at 3/4 of the size";
  LivePace slower(configured());
  run(&slower, oneInFive(0.09), 60.0);
  EXPECT_EQ(slower.lowered(), 2U) << "29 ms at half the size";
}

/** [s] One frame in twenty, at random, is late whatever its size: the machine has other work. */
TEST(LivePace, LateFramesByChanceChangeNothing) {
  LivePace pace(configured());
  std::mt19937 random(7);
  std::bernoulli_distribution is_late(0.05);
  const Load load = [&](const LiveLevel&, double) { return is_late(random) ? 0.06 : 0.02; };
  EXPECT_TRUE(run(&pace, load, 600.0).empty());
}

TEST(LivePace, TheRateStaysWhereOneFrameInFiveIsLateAtTheSmallestSize) {
  LivePace pace(configured());
  run(&pace, oneInFive(0.5), 60.0);
  EXPECT_EQ(pace.lowered(), 2U);
  EXPECT_EQ(pace.level().fps, 30);
  LivePace fixed(configured(30, 10, 1.0));
  EXPECT_TRUE(run(&fixed, oneInFive(0.06), 60.0).empty()) << "no smaller size is allowed";
}

/** One frame in five stays late whatever the rate, so that it is no reason to keep a low one. */
TEST(LivePace, TheRateRecoversAlthoughOneFrameInFiveIsLate) {
  LivePace pace(configured());
  run(&pace, byPixels(0.16), 20.0);
  ASSERT_EQ(pace.level().fps, 15);
  run(&pace, oneInFive(0.3), 60.0);
  EXPECT_EQ(pace.level().fps, 30);
  EXPECT_EQ(pace.lowered(), 2U) << "the size stays";
}

TEST(LivePace, ItRecoversALevelAtATimeOnceThereIsRoom) {
  LivePace pace(configured());
  const Load burst = [](const LiveLevel& level, double time) {
    return byPixels(time < 20.0 ? 0.5 : 0.01)(level, time);
  };
  const std::vector<Change> changes = run(&pace, burst, 200.0);
  ASSERT_EQ(changes.size(), 10U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(changes[i].level, i + 1);
    EXPECT_EQ(changes[i + 5].level, 4 - i);
    EXPECT_GE(changes[i + 5].time - changes[i + 4].time, 3.0) << "not before it has settled";
  }
  EXPECT_EQ(pace.lowered(), 0U);
}

/** Under any constant load with 10 % noise, the pace never returns to a level that it left. */
TEST(LivePace, AConstantLoadNeverOscillates) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(1.0, 0.1);
  for (double whole = 0.005; whole < 0.5; whole *= 1.03) {
    LivePace pace(configured());
    const Load load = [&](const LiveLevel& level, double time) {
      return byPixels(whole)(level, time) * std::max(0.5, noise(random));
    };
    std::uint32_t before = 0;
    for (const Change& change : run(&pace, load, 300.0)) {
      EXPECT_EQ(change.level, before + 1) << whole << " at " << change.time;
      before = change.level;
    }
  }
}

/** If the load rises whenever the picture grows, the pace tries a larger picture less and less often. */
TEST(LivePace, AnAdverseLoadChangesItSeldom) {
  LivePace pace(configured());
  const Load adverse = [&pace](const LiveLevel&, double) { return pace.lowered() == 0 ? 0.05 : 0.01; };
  const std::vector<Change> changes = run(&pace, adverse, 1800.0);
  EXPECT_LE(changes.size(), 2U * (1800U / 60U + 6U)) << "a rise and a fall a minute, once the wait has grown";
  EXPECT_GE(changes.size(), 10U) << "but it still tries";
}

/** A level that has lasted for a minute was right: after the next fall the wait is as short as after the first. */
TEST(LivePace, AfterAMinuteAboveTheWaitIsShortAgain) {
  LivePace pace(configured(30, 20, 1.0));
  const Load adverse = [&pace](const LiveLevel&, double) { return pace.lowered() == 0 ? 0.05 : 0.01; };
  const Load calm = [](const LiveLevel&, double) { return 0.01; };
  const Load slow = [](const LiveLevel&, double) { return 0.05; };
  run(&pace, adverse, 60.0);  // falls soon after four rises
  ASSERT_EQ(pace.lowered(), 1U);
  const std::vector<Change> late = run(&pace, calm, 200.0);
  ASSERT_EQ(late.size(), 1U);
  EXPECT_GT(late[0].time, 10.0) << "the wait has grown";
  EXPECT_LT(late[0].time, 200.0 - LivePace::kLongest);
  ASSERT_EQ(run(&pace, slow, 2.0).size(), 1U);
  const std::vector<Change> soon = run(&pace, calm, 20.0);
  ASSERT_EQ(soon.size(), 1U);
  EXPECT_EQ(soon[0].level, 0U);
  EXPECT_GT(soon[0].time, 2.4) << "settle, less half a second of calm before";
  EXPECT_LT(soon[0].time, 4.5);
}

TEST(LivePace, AnyFramesKeepItWithinItsLevels) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> exponent(-5.0, 1.0);
  LivePace pace(configured(120, 1, 0.25));
  for (int i = 0; i < 200000; ++i) {
    pace.add(std::pow(10.0, exponent(random)));
    ASSERT_LT(pace.lowered(), pace.levels().size());
  }
}

}  // namespace
}  // namespace raven2_trainer::daemon
