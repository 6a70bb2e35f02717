#include "raven2_trainer/training/usb_truth.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gtest/gtest.h"
#include "motion_support.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::training {
namespace {

namespace fs = std::filesystem;
constexpr std::int64_t kMillisecond = 1'000'000, kSecond = 1000 * kMillisecond, kDay = 86'400 * kSecond;  // [ns]
constexpr std::int64_t kBegan = 500 * kSecond;              // [ns] CLOCK_MONOTONIC of the session's first tick
constexpr std::int64_t kStart = 1'700'000'000 * kSecond;    // [ns] since 1970
constexpr const char* kStartText = "2023-11-14T22:13:20Z";  // kStart
constexpr Tick kInjection = 2000;                           // [1 ms] since the first tick

/** A session of a real robot whose control program runs on the simulator's computer. */
class UsbTruthTest : public ::testing::Test {
 protected:
  UsbTruthTest() {
    fs::create_directories(folder_);
    session::LogHeader header;
    header.scenarios = {"sudden_jump"};
    session::LogWriter writer(paths_.log(), header);
    for (Tick k = 0; k < 4000; ++k) {
      TickRecord record = makeRecord(k);
      record.model.time_ns = record.robot.time_ns = kBegan + k * kMillisecond;
      record.robot.last_sequence = static_cast<std::uint32_t>(100 + k);
      writer.write(record);
    }
    writer.finish({});
    writeMeta(kStartText);
  }
  ~UsbTruthTest() override { fs::remove_all(folder_); }
  UsbTruthTest(const UsbTruthTest&) = delete;
  UsbTruthTest& operator=(const UsbTruthTest&) = delete;

  void writeMeta(const std::string& start) const {
    std::ofstream(paths_.meta()) << nlohmann::json{{"start_time_utc", start}};
  }

  /** An injection at kInjection by CLOCK_MONOTONIC; by the file's wall clock the session began `late` after kStart. */
  void writeTruth(std::int64_t late) const {
    const std::int64_t offset = kStart - kBegan + late;
    const nlohmann::json inject{
        {"cycle", 7}, {"time_ns", kBegan + kInjection * kMillisecond + offset}, {"command", 100 + kInjection}};
    const nlohmann::json injection{
        {"name", "sudden_jump"}, {"host", "robot"},  {"row", 0},        {"site", "put_usb_packet"},
        {"variable", "dac"},     {"arm", "gold"},    {"channel", 1},    {"kind", "stuck_at"},
        {"value", 8000},         {"inject", inject}, {"clear", nullptr}};
    std::ofstream(file_) << nlohmann::json{{"scenario", "sudden_jump"},
                                           {"monotonic_offset_ns", offset},
                                           {"ended_ns", kStart + late + 10 * kSecond},
                                           {"injections", {injection}}};
  }

  /** At `k`, when the robot takes command 100 + k; the file says the command `later`. Before the session: no command.
   */
  static nlohmann::json momentOf(Tick k, Tick later = 0) {
    return {{"cycle", 7}, {"time_ns", kStart + k * kMillisecond}, {"command", k < 0 ? 0 : 100 + k + later}};
  }

  /** Lasts to the end of the program. */
  static nlohmann::json injectionOf(const nlohmann::json& inject, bool is_of_packets = false) {
    return {{"name", "sudden_jump"},
            {"host", "robot"},
            {"row", 0},
            {"site", is_of_packets ? "network_layer" : "put_usb_packet"},
            {"variable", is_of_packets ? "increment" : "dac"},
            {"arm", "gold"},
            {"channel", 1},
            {"kind", "stuck_at"},
            {"value", 8000},
            {"inject", inject},
            {"clear", nullptr}};
  }

  void writeInjections(const std::vector<nlohmann::json>& injections,
                       std::int64_t offset = kStart - kBegan,
                       std::int64_t ended = kStart + 10 * kSecond) const {
    std::ofstream(file_) << nlohmann::json{
        {"scenario", "sudden_jump"}, {"monotonic_offset_ns", offset}, {"ended_ns", ended}, {"injections", injections}};
  }

  void expectRefused(const std::string& words) const {
    try {
      mergeUsbTruth(file_, paths_, TruthBy::kClockAlone);
      ADD_FAILURE() << "merged";
    } catch (const SessionException& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
    EXPECT_FALSE(fs::exists(paths_.usbTruth()));
  }

  fs::path folder_{fs::temp_directory_path() / ("usb_truth_test_" + std::to_string(::getpid()))};
  session::SessionPaths paths_{folder_.string()};
  std::string file_{(folder_ / "truth.json").string()};
};

TEST_F(UsbTruthTest, TheClockAloneFindsAnInjectionOfTheSameDay) {
  for (const std::int64_t late : {-9 * kSecond, 0 * kSecond, 9 * kSecond}) {
    writeTruth(late);
    const TruthMerge merged = mergeUsbTruth(file_, paths_, TruthBy::kClockAlone);
    EXPECT_EQ(merged.inside, 1U);
    EXPECT_TRUE(merged.by_clock);
    const UsbTruth truth = loadUsbTruth(paths_.usbTruth()).value();
    ASSERT_EQ(truth.changes.size(), 1U);
    EXPECT_EQ(truth.changes[0].tick, kFirstTick + kInjection);
  }
}

TEST_F(UsbTruthTest, TheClockAloneRefusesAFileOfAnotherStartOfTheComputer) {
  for (const std::int64_t late : {-kDay, -11 * kSecond, 11 * kSecond, kDay}) {
    writeTruth(late);
    expectRefused("allowed are 10 s");
    EXPECT_EQ(mergeUsbTruth(file_, paths_, TruthBy::kClockOrCommands).inside, 1U) << "the user named it";
    fs::remove(paths_.usbTruth());
  }
}

TEST_F(UsbTruthTest, TheClockAloneNeedsTheSessionsStart) {
  writeTruth(0);
  for (const char* start : {"", "yesterday"}) {
    writeMeta(start);
    expectRefused("start_time_utc");
  }
  fs::remove(paths_.meta());
  expectRefused("start_time_utc");
}

/** Each thread of the control program writes its own injections, so a file is not in the order of time. */
TEST_F(UsbTruthTest, InjectionsAreFoundInAnyOrder) {
  for (const bool by_clock : {true, false}) {
    writeInjections({injectionOf(momentOf(3000)), injectionOf(momentOf(1000))}, by_clock ? kStart - kBegan : 0);
    EXPECT_EQ(mergeUsbTruth(file_, paths_, TruthBy::kClockOrCommands).by_clock, by_clock);
    const UsbTruth truth = loadUsbTruth(paths_.usbTruth()).value();
    ASSERT_EQ(truth.changes.size(), 2U);
    EXPECT_EQ(truth.changes[0].tick, kFirstTick + 1000);
    EXPECT_EQ(truth.changes[1].tick, kFirstTick + 3000);
  }
}

/** A command that an injection into packets names may never have been taken: it says nothing. */
TEST_F(UsbTruthTest, ClockAndCommandsAgreeWithinAFifthOfASecondEitherWay) {
  for (const Tick later : {-1000, -201, -200, 200, 201, 1000}) {
    for (const bool is_of_packets : {false, true}) {
      writeInjections({injectionOf(momentOf(kInjection, later), is_of_packets)});
      if (is_of_packets || std::abs(later) <= 200) {
        EXPECT_EQ(mergeUsbTruth(file_, paths_, TruthBy::kClockOrCommands).inside, 1U) << later;
      } else {
        EXPECT_THROW(mergeUsbTruth(file_, paths_, TruthBy::kClockOrCommands), SessionException) << later;
      }
    }
  }
}

TEST_F(UsbTruthTest, WhatLastedToTheEndOfAnEarlierProgramDoesNotActInTheSession) {
  writeInjections({injectionOf(momentOf(-5000))}, kStart - kBegan, kStart - kSecond);
  expectRefused("none of its 1 injections");
  writeInjections({injectionOf(momentOf(-5000))}, kStart - kBegan, kStart + kSecond);
  EXPECT_EQ(mergeUsbTruth(file_, paths_, TruthBy::kClockAlone).inside, 1U) << "this program ran in the session";
  EXPECT_EQ(loadUsbTruth(paths_.usbTruth()).value().changes.at(0).tick, kFirstTick);
}

TEST_F(UsbTruthTest, ChangesThatTheLibraryLostAreLostToTheSession) {
  writeInjections({injectionOf(momentOf(kInjection))});
  nlohmann::json truth;
  std::ifstream in(file_);
  in >> truth;
  in.close();
  truth["changes_lost"] = 3;
  std::ofstream(file_) << truth;
  ASSERT_EQ(mergeUsbTruth(file_, paths_, TruthBy::kClockOrCommands).inside, 1U);
  EXPECT_EQ(loadUsbTruth(paths_.usbTruth()).value().lost, 3U);
  EXPECT_EQ(computeMetrics(paths_.log()).counts.fault_changes_lost, 3U);
}

}  // namespace
}  // namespace raven2_trainer::training
