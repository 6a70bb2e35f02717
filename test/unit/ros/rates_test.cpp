#include "ros/node/rates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ros/bridge/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

using diagnostic_msgs::DiagnosticStatus;

DiagnosticStatus counting(const std::string& name, const std::string& key, std::uint64_t count) {
  DiagnosticStatus status;
  status.name = kStatusPrefix + name;
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = std::to_string(count);
  status.values.push_back(pair);
  return status;
}

std::string rateIn(const DiagnosticStatus& status) {
  for (const auto& pair : status.values)
    if (pair.key == "rate_hz") return pair.value;
  return "none";
}

/** @return what Rates makes of a status with `count` and `failed` at `now_ns`. */
DiagnosticStatus after(Rates* rates,
                       std::uint64_t count,
                       std::int64_t now_ns,
                       double expected = 0.0,
                       std::uint64_t failed = 0) {
  diagnostic_msgs::DiagnosticArray array;
  array.status = {counting("one", "sent", count)};
  array.status[0].values.push_back(counting("", "failed", failed).values[0]);
  rates->addTo(&array, {{"one", "sent", expected, "failed"}}, now_ns);
  return array.status[0];
}

std::string rateAfter(Rates* rates, std::uint64_t count, std::int64_t now_ns) {
  return rateIn(after(rates, count, now_ns));
}

TEST(Rates, AreWhatWasCountedInTheTimeBetween) {
  Rates rates;
  EXPECT_EQ(rateAfter(&rates, 5000, 10 * kSecond), "none") << "the count before is unknown";
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, 6000, 11 * kSecond)), 1000.0);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, 6030, 13 * kSecond)), 15.0);
}

TEST(Rates, OfAnArrayInBetweenAreThoseOfBefore) {
  Rates rates;
  rateAfter(&rates, 0, kSecond);
  EXPECT_EQ(rateAfter(&rates, 7, kSecond + kSecond / 20), "none");
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, 30, 2 * kSecond)), 30.0);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, 31, 2 * kSecond + kSecond / 20)), 30.0);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, 45, 3 * kSecond)), 15.0);
}

TEST(Rates, ACounterThatBeganAnewIsNoNegativeRate) {
  Rates rates;
  rateAfter(&rates, 1000000, kSecond);
  EXPECT_DOUBLE_EQ(std::stod(rateAfter(&rates, 200, 2 * kSecond)), 200.0);
}

TEST(Rates, OfEachStatusByItsNameAndTheCounterThatIsNamed) {
  Rates rates;
  const std::vector<Stream> streams{{"a", "ticks"}, {"b", "sent"}, {"gone", "sent"}};
  for (const std::int64_t second : {1, 2}) {
    diagnostic_msgs::DiagnosticArray array;
    const auto count = static_cast<std::uint64_t>(second);
    array.status = {counting("a", "ticks", 10 * count), counting("b", "received", 0),
                    counting("c", "ticks", 30 * count)};
    array.status[1].values.push_back(counting("", "sent", 20 * count).values[0]);
    rates.addTo(&array, streams, second * kSecond);
    if (second == 1) continue;
    EXPECT_DOUBLE_EQ(std::stod(rateIn(array.status[0])), 10.0);
    EXPECT_DOUBLE_EQ(std::stod(rateIn(array.status[1])), 20.0) << "sent, not received";
    EXPECT_EQ(rateIn(array.status[2]), "none");
  }
}

TEST(Rates, WhatShouldTalkAndIsSilentIsAWarning) {
  Rates rates;
  after(&rates, 1000, kSecond, 1000.0);
  EXPECT_EQ(after(&rates, 2000, 2 * kSecond, 1000.0).level, DiagnosticStatus::OK);
  const DiagnosticStatus silent = after(&rates, 2000, 3 * kSecond, 1000.0);
  EXPECT_EQ(silent.level, DiagnosticStatus::WARN);
  EXPECT_NE(silent.message.find("silent"), std::string::npos) << silent.message;
  const DiagnosticStatus between = after(&rates, 2000, 3 * kSecond + kSecond / 20, 1000.0);
  EXPECT_EQ(between.level, DiagnosticStatus::WARN) << "the warning stays until the next second";
  EXPECT_EQ(after(&rates, 3000, 4 * kSecond, 1000.0).level, DiagnosticStatus::OK);
}

TEST(Rates, ATenthLessThanExpectedIsGoodMoreIsNot) {
  for (const auto& [count, level] : {std::pair<std::uint64_t, int>{1000, DiagnosticStatus::OK},
                                     {900, DiagnosticStatus::OK},
                                     {898, DiagnosticStatus::WARN}}) {
    Rates rates;
    after(&rates, 0, kSecond, 1000.0);
    const DiagnosticStatus status = after(&rates, count, 2 * kSecond, 1000.0);
    EXPECT_EQ(status.level, level) << count << status.message;
  }
  Rates rates;
  after(&rates, 0, kSecond, 1000.0);
  const std::string words = after(&rates, 500, 2 * kSecond, 1000.0).message;
  EXPECT_NE(words.find("500 Hz where 1000 are expected"), std::string::npos) << words;
}

/** A picture of 10 Hz may have 9 or 10 frames in a second. */
TEST(Rates, OneMoreOrLessInASecondIsNothing) {
  Rates rates;
  after(&rates, 0, kSecond, 10.0);
  EXPECT_EQ(after(&rates, 9, 2 * kSecond + kSecond / 20, 10.0).level, DiagnosticStatus::OK);
}

TEST(Rates, WhatBeganToBeExpectedInBetweenIsNotJudgedYet) {
  Rates rates;
  after(&rates, 0, kSecond, 0.0);
  EXPECT_EQ(after(&rates, 100, 2 * kSecond, 1000.0).level, DiagnosticStatus::OK);
  EXPECT_EQ(after(&rates, 200, 3 * kSecond, 1000.0).level, DiagnosticStatus::WARN);
}

/** The viewer of the pictures left within the second. */
TEST(Rates, WhatIsNotExpectedAnyMoreMayBeSilent) {
  Rates rates;
  after(&rates, 0, kSecond, 30.0);
  EXPECT_EQ(after(&rates, 5, 2 * kSecond, 0.0).level, DiagnosticStatus::OK);
  EXPECT_EQ(after(&rates, 6, 3 * kSecond, 0.0).level, DiagnosticStatus::OK);
}

TEST(Rates, WhatNobodyExpectsMayBeSilentAndFail) {
  Rates rates;
  for (const std::int64_t second : {1, 2, 3})
    EXPECT_EQ(after(&rates, 0, second * kSecond, 0.0, 500U * static_cast<std::uint64_t>(second)).level,
              DiagnosticStatus::OK);
}

TEST(Rates, FailuresThatGrowAreAWarning) {
  Rates rates;
  after(&rates, 0, kSecond, 1000.0, 5);
  EXPECT_EQ(after(&rates, 1000, 2 * kSecond, 1000.0, 5).level, DiagnosticStatus::OK) << "only old failures";
  const DiagnosticStatus failing = after(&rates, 2000, 3 * kSecond, 1000.0, 8);
  EXPECT_EQ(failing.level, DiagnosticStatus::WARN);
  EXPECT_NE(failing.message.find("3 could not be sent"), std::string::npos) << failing.message;
  EXPECT_EQ(after(&rates, 3000, 4 * kSecond, 1000.0, 8).level, DiagnosticStatus::OK);
}

TEST(Rates, AnErrorStaysOne) {
  Rates rates;
  diagnostic_msgs::DiagnosticArray array;
  array.status = {counting("one", "sent", 0)};
  for (const std::int64_t second : {1, 2}) {
    array.status[0].level = DiagnosticStatus::ERROR;
    rates.addTo(&array, {{"one", "sent", 1000.0}}, second * kSecond);
  }
  EXPECT_EQ(array.status[0].level, DiagnosticStatus::ERROR);
}

// ---- the daemon's streams

class DaemonStreams : public ::testing::Test {
 protected:
  /** The daemon's statuses one second later. */
  diagnostic_msgs::DiagnosticArray tell() {
    now_ns += kSecond;
    auto array = diagnostics(counts, *shared, RobotState{}, now_ns, "real-time", ros::Time(1, 0));
    array.status.push_back(pictureStatus(picture));
    array.status.push_back(linkStatus("pedals to daemon", LinkCounts{}));
    rates.addTo(&array, streams(counts, picture), now_ns);
    return array;
  }

  static DiagnosticStatus of(const diagnostic_msgs::DiagnosticArray& array, const std::string& name) {
    for (const DiagnosticStatus& status : array.status)
      if (status.name == kStatusPrefix + name) return status;
    ADD_FAILURE() << "no status of " << name;
    return {};
  }

  void count(LinkCounts* link, std::uint64_t packets) {
    link->received += packets;
    link->applied += packets;
  }

  void loops() {
    for (LoopTiming& loop : counts.loops) {
      loop.ticks += 1000;
      loop.on_time += 1000;
    }
  }

  SessionCounts counts{};
  LivePicture picture{};
  std::unique_ptr<SharedState> shared = std::make_unique<SharedState>();
  Rates rates;
  std::int64_t now_ns{0};
};

constexpr std::array kLinks{"master to daemon link", "daemon to robot link", "robot to daemon link",
                            "pedals to daemon link", "forces to console"};

TEST_F(DaemonStreams, NameStatusesAndCountersThatThereAre) {
  const auto array = tell();
  for (const Stream& stream : streams(counts, picture)) {
    const auto& values = of(array, stream.status).values;
    for (const std::string& key : {stream.counter, stream.failures}) {
      const auto is_it = [key = key](const auto& pair) { return pair.key == key; };
      EXPECT_TRUE(key.empty() || std::any_of(values.begin(), values.end(), is_it)) << stream.status << ": " << key;
    }
  }
}

TEST_F(DaemonStreams, ALinkThatNobodyConnectedToIsGoodAndSaysSo) {
  for (int second = 0; second < 3; ++second) {
    loops();
    counts.relay_sent += 500;
    counts.relay_failed += 500;  // nobody listens on the robot's port
    counts.force_failed += 1000;
    const auto array = tell();
    for (const char* name : kLinks) {
      EXPECT_EQ(of(array, name).level, DiagnosticStatus::OK) << name;
      EXPECT_EQ(of(array, name).message, "not connected") << name;
    }
  }
}

TEST_F(DaemonStreams, AConsoleAndARobotThatWereThereAndAreSilentAreWarnings) {
  diagnostic_msgs::DiagnosticArray array;
  const auto second = [&] {
    loops();
    counts.relay_sent += 1000;
    counts.force_sent += 1000;
    array = tell();
  };
  for (int i = 0; i < 3; ++i) {
    count(&counts.master, 1000);
    count(&counts.robot_state, 1000);
    second();
    for (const char* name : kLinks)
      EXPECT_EQ(of(array, name).level, DiagnosticStatus::OK) << name << ": " << of(array, name).message;
  }
  second();
  for (const char* name : {"master to daemon link", "robot to daemon link"}) {
    EXPECT_EQ(of(array, name).level, DiagnosticStatus::WARN) << name;
    EXPECT_NE(of(array, name).message.find("silent"), std::string::npos) << name;
  }
  EXPECT_EQ(of(array, "daemon to robot link").level, DiagnosticStatus::OK) << "the daemon does send";
}

TEST_F(DaemonStreams, AConsoleOfWhichNothingIsTakenIsAWarning) {
  for (int i = 0; i < 3; ++i) {
    counts.master.received += 1000;
    counts.master.rejected[1] += 1000;
    tell();
  }
  EXPECT_EQ(of(tell(), "master to daemon link").level, DiagnosticStatus::WARN);
}

/** A real Raven's states do not count the packets that it received. */
TEST_F(DaemonStreams, TheRateToARealRobotIsThatOfWhatIsSent) {
  for (int i = 0; i < 3; ++i) {
    count(&counts.robot_state, 1000);
    counts.relay_sent += 1000;
    loops();
    if (i < 2) tell();
  }
  const DiagnosticStatus status = of(tell(), "daemon to robot link");
  EXPECT_DOUBLE_EQ(std::stod(rateIn(status)), 1000.0);
  EXPECT_EQ(status.level, DiagnosticStatus::OK) << status.message;
}

TEST_F(DaemonStreams, ForcesThatDoNotGoOutAreAWarning) {
  count(&counts.master, 1000);
  tell();
  count(&counts.master, 1000);
  counts.force_failed += 1000;
  const DiagnosticStatus failing = of(tell(), "forces to console");
  EXPECT_EQ(failing.level, DiagnosticStatus::WARN);
  EXPECT_NE(failing.message.find("1000 could not be sent"), std::string::npos) << failing.message;
  count(&counts.master, 1000);
  EXPECT_EQ(of(tell(), "forces to console").level, DiagnosticStatus::WARN) << "no force is sent";
}

TEST_F(DaemonStreams, ALoopThatStoppedIsAWarning) {
  loops();
  tell();
  loops();
  EXPECT_EQ(of(tell(), "physics loop").level, DiagnosticStatus::OK);
  EXPECT_EQ(of(tell(), "physics loop").level, DiagnosticStatus::WARN);
}

TEST_F(DaemonStreams, PicturesAreExpectedWhileSomebodyLooks) {
  picture.fps = 30;
  tell();
  ++picture.frames;
  EXPECT_EQ(of(tell(), "live picture").level, DiagnosticStatus::OK) << "one picture a second without a viewer";
  picture.watched = 1;
  tell();
  picture.frames += 30;
  EXPECT_EQ(of(tell(), "live picture").level, DiagnosticStatus::OK);
  picture.frames += 10;
  EXPECT_EQ(of(tell(), "live picture").level, DiagnosticStatus::WARN);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
