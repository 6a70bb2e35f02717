#include "raven2_trainer/wire/stream_watch.h"

#include <gtest/gtest.h>

#include <set>

namespace raven2_trainer::wire {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

/** A console at 1 kHz, looked at every 100 ms. */
class StreamWatchTest : public ::testing::Test {
 protected:
  /** @param[in] bad of ten packets, refused for `reason`. @return the number of findings. */
  int seconds(int count, int bad, Reject reason = Reject::kBadQuaternion, int rate = 1000) {
    int told = 0;
    for (int ms = 0; ms < 1000 * count; ++ms) {
      const int every = 1000 / rate;
      if (ms % every == 0) counts.count((ms / every) % 10 < bad ? reason : Reject::kNone);
      now_ns += kMillisecond;
      if (ms % 100 == 99 && watch.look(counts, now_ns) && watch.finding().number > told_number) {
        ++told;
        told_number = watch.finding().number;
      }
    }
    return told;
  }
  StreamWatch watch;
  LinkCounts counts;
  std::int64_t now_ns{0};
  std::uint32_t told_number{0};
};

TEST_F(StreamWatchTest, WhatIsTakenForTheMostPartIsNotTold) {
  EXPECT_EQ(seconds(5, 0), 0);
  EXPECT_EQ(seconds(5, 5), 0) << "half is not more than half";
  EXPECT_EQ(watch.finding().lasts, 0);
}

TEST_F(StreamWatchTest, WhatIsRefusedForTheMostPartIsToldOnceWithTheReason) {
  EXPECT_EQ(seconds(30, 6), 1);
  EXPECT_EQ(watch.finding().reason, Reject::kBadQuaternion);
  EXPECT_EQ(watch.finding().lasts, 1);
  EXPECT_NEAR(watch.finding().refused, 600, 60);
  const std::string text = sentence(watch.finding());
  EXPECT_NE(text.find("bad_quaternion"), std::string::npos) << text;
  EXPECT_NE(text.find("doc/streams.md"), std::string::npos) << text;
}

TEST_F(StreamWatchTest, AfterAGoodSecondItIsToldAgainAndAfterASilenceNot) {
  EXPECT_EQ(seconds(3, 10), 1);
  EXPECT_EQ(seconds(3, 10, Reject::kBadQuaternion, 10), 0) << "too few to be a console's";
  EXPECT_EQ(watch.finding().lasts, 0);
  EXPECT_EQ(seconds(3, 10), 0);
  EXPECT_EQ(seconds(3, 10, Reject::kOutOfRange), 1) << "another reason";
  seconds(3, 0);
  EXPECT_EQ(watch.finding().lasts, 0);
  EXPECT_EQ(seconds(3, 10, Reject::kOutOfRange), 1);
}

TEST(StreamWatch, EveryReasonOfAConsolesHasSomethingToDo) {
  const std::set<Reject> of_a_robots_link{Reject::kNone, Reject::kQueueFull, Reject::kBadVersion, Reject::kStale};
  for (std::size_t i = 0; i < kRejectCount; ++i) {
    StreamFinding finding;
    finding.reason = static_cast<Reject>(i);
    const bool is_known = sentence(finding).find("metrics.json") == std::string::npos;
    EXPECT_EQ(is_known, of_a_robots_link.count(finding.reason) == 0) << kRejectNames[i];
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
