#include "raven2_trainer/recording/timing_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace raven2_trainer::recording {
namespace {

LoopTiming timing(std::uint64_t ticks, std::uint64_t late) {
  LoopTiming result;
  result.ticks = ticks;
  result.on_time = ticks - late;
  result.slips = late;
  return result;
}

TEST(TimingVerdict, AllowsThreeTimesTheMissesOfABareThreadAndAThousandth) {
  const LoopTiming bare = timing(10000, 10);  // 0.1 %
  EXPECT_TRUE(judgeTiming(timing(10000, 39), bare).pass);
  EXPECT_FALSE(judgeTiming(timing(10000, 41), bare).pass);
  EXPECT_TRUE(judgeTiming(timing(10000, 9), timing(10000, 0)).pass);
  EXPECT_FALSE(judgeTiming(timing(10000, 11), timing(10000, 0)).pass);
}

TEST(TimingVerdict, SpeaksAsLibfrankasTest) {
  const LoopTiming bare = timing(1000, 0);
  EXPECT_STREQ(judgeTiming(timing(1000, 49), bare).words, "good");
  EXPECT_STREQ(judgeTiming(timing(1000, 51), bare).words, "warn");
  EXPECT_STREQ(judgeTiming(timing(1000, 101), bare).words, "bad");
}

TEST(TimingVerdict, LostTimeAndNoTicksFail) {
  LoopTiming slipped = timing(1000, 0);
  slipped.time_slips = 1;
  EXPECT_FALSE(judgeTiming(slipped, timing(1000, 0)).pass);
  EXPECT_FALSE(judgeTiming(LoopTiming{}, timing(1000, 0)).pass);
  EXPECT_FALSE(judgeTiming(timing(1000, 0), LoopTiming{}).pass);
}

TEST(TimingVerdict, AFailureSaysItsReasonAndNothingGood) {
  LoopTiming slipped = timing(1000, 0);
  slipped.time_slips = 1;
  const auto lastLine = [](const LoopTiming& loop, const LoopTiming& bare) {
    const std::string text = timingText("physics", loop, bare);
    EXPECT_EQ(text.find("good"), std::string::npos);
    return text.substr(text.rfind('\n', text.size() - 2) + 1);
  };
  EXPECT_EQ(lastLine(timing(1000, 0), timing(1000, 0)), "  pass\n");
  EXPECT_EQ(lastLine(timing(1000, 30), timing(1000, 0)), "  FAIL: more ticks missed than allowed\n");
  EXPECT_EQ(lastLine(slipped, timing(1000, 0)), "  FAIL: the loop was so late that it gave up time\n");
  EXPECT_EQ(lastLine(LoopTiming{}, timing(1000, 0)), "  FAIL: nothing was measured\n");
  EXPECT_EQ(lastLine(timing(1000, 100), timing(1000, 99)),
            "  pass, but only 90.0 % of the ticks are on time, and bare threads are no better\n");
}

TEST(TimingReport, DrawsALineForEveryOctaveThatOccurred) {
  Histogram histogram;
  for (int i = 0; i < 1000; ++i)
    histogram.add(5000);  // 4.1 to 8.2 us
  histogram.add(300'000'000);
  const std::string text = histogramText(histogram);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
  EXPECT_NE(text.find("from       4.1 us      1000 " + std::string(50, '#') + "\n"), std::string::npos) << text;
  EXPECT_NE(text.find("from  268435.5 us         1 #"), std::string::npos) << text;
}

TEST(TimingReport, HasTheCountsAndTheVerdictForPrograms) {
  LoopTiming loop = timing(2000, 1);
  loop.longest_late_run = 1;
  loop.late_runs = 1;
  loop.run.add(100'000);
  loop.max_run_ns = 100'000;
  const auto json = timingJson(loop, timing(1000, 0));
  EXPECT_EQ(json.at("ticks"), 2000);
  EXPECT_EQ(json.at("late_runs"), 1);
  EXPECT_EQ(json.at("run").at("max_us"), 100.0);
  EXPECT_EQ(json.at("run").at("buckets_upto_us").size(), 1U);
  EXPECT_EQ(json.at("verdict"), "good");
  EXPECT_EQ(json.at("pass"), true);
}

TEST(TimingReport, EachFigureIsItsOwn) {
  LoopTiming loop = timing(2000, 0), bare = timing(1000, 1);
  loop.wake_up.add(5'000);
  loop.run.add(100'000);
  loop.run.add(300'000);
  loop.max_late_ns = 7'000;
  loop.max_run_ns = 350'000;
  loop.minor_faults = 3;
  loop.major_faults = 4;
  loop.time_slips = 5;
  bare.max_late_ns = 9'000;
  bare.longest_late_run = 2;
  const auto json = timingJson(loop, bare);
  EXPECT_DOUBLE_EQ(json.at("wake_up").at("max_us").get<double>(), 7.0);
  EXPECT_EQ(json.at("wake_up").at("buckets_upto_us").size(), 1U);
  EXPECT_DOUBLE_EQ(json.at("run").at("max_us").get<double>(), 350.0);
  EXPECT_EQ(json.at("run").at("buckets_upto_us").size(), 2U);
  EXPECT_DOUBLE_EQ(json.at("calibration").at("wake_up").at("max_us").get<double>(), 9.0);
  EXPECT_EQ(json.at("calibration").at("longest_late_run"), 2);
  EXPECT_EQ(json.at("minor_faults"), 3);
  EXPECT_EQ(json.at("major_faults"), 4);
  EXPECT_EQ(json.at("time_slips"), 5);
  const std::string text = timingText("physics", loop, bare);
  for (const char* most : {"max      7.0 us\n", "max    350.0 us\n", "max      9.0 us\n"})
    EXPECT_NE(text.find(most), std::string::npos) << text;
}

}  // namespace
}  // namespace raven2_trainer::recording
