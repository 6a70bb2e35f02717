#include "raven2_trainer/runtime/recorder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"
#include "support/rig.h"

namespace raven2_trainer::runtime {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond = 1'000'000'000;

void limitFileSize(rlim_t bytes) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur = bytes;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

class RecorderTest : public ::testing::Test {
 protected:
  RecorderTest()
      : paths{::testing::TempDir() + "/raven2_recorder_" + std::to_string(getpid())},
        config(raven2_trainer::testing::packagedConfig()) {
    fs::remove_all(paths.directory);
    fs::create_directories(paths.directory);
    recorder = std::make_unique<Recorder>(config, std::vector<std::string>{}, paths, "", &shared);
  }
  ~RecorderTest() override {
    limitFileSize(RLIM_INFINITY);
    fs::remove_all(paths.directory);
  }

  void push(Tick count) {
    for (Tick i = 0; i < count; ++i) {
      TickRecord record;
      record.model.tick = next_tick++;
      shared.tick_records.tryPush(record);
      shared.haptic_records.tryPush(HapticRecord{});
    }
  }

  session::LogSummary read() {
    ticks.clear();
    gaps.clear();
    session::LogVisitor visitor;
    visitor.tick = [this](const TickRecord& record) { ticks.push_back(record.model.tick); };
    visitor.gap = [this](const GapRecord& gap) { gaps.push_back(gap); };
    return session::readLog(paths.log(), visitor);
  }

  session::SessionPaths paths;
  TrainerConfig config;
  SharedState shared;
  std::unique_ptr<Recorder> recorder;
  Tick next_tick{0};
  std::vector<Tick> ticks;
  std::vector<GapRecord> gaps;
};

TEST_F(RecorderTest, SaysInTheLogExactlyWhatAFullDiskCost) {
  push(100);
  recorder->drain(kSecond);
  // GIVEN a disk that is full for longer than the queues of 2048 last
  limitFileSize(fs::file_size(paths.log()));
  push(10);
  recorder->drain(kSecond);
  EXPECT_EQ(shared.recorder.load().failing, 1);
  EXPECT_EQ(shared.recorder.load().error, EFBIG);
  push(3000);
  recorder->drain(2 * kSecond);
  EXPECT_EQ(shared.recorder.load().lost, 2 * (3010u - 2048u));
  // WHEN there is room again
  limitFileSize(RLIM_INFINITY);
  recorder->drain(2 * kSecond + kSecond / 4);
  EXPECT_EQ(shared.recorder.load().failing, 1) << "not tried before its time";
  recorder->drain(3 * kSecond);
  EXPECT_EQ(shared.recorder.load().failing, 0);
  push(5);
  recorder->finish(SessionCounts{});
  // THEN all but what did not fit in the queues is there, and the log says so
  const session::LogSummary summary = read();
  EXPECT_TRUE(summary.clean);
  EXPECT_EQ(summary.bad_bytes, 0u);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].reason, GapReason::kNotWritten);
  EXPECT_EQ(gaps[0].error, EFBIG);
  EXPECT_EQ(gaps[0].lost, (RecordTally{962, 962, 0, 0, 0, 0, 0}));
  EXPECT_EQ(gaps[0].tick, 2147);
  ASSERT_EQ(ticks.size(), 100u + 2048u + 5u);
  EXPECT_EQ(ticks[2147], 2147);
  EXPECT_EQ(ticks[2148], 2148 + 962);
}

TEST_F(RecorderTest, SaysThatItDidNotKeepUp) {
  push(2048 + 3);
  recorder->drain(kSecond);
  recorder->finish(SessionCounts{});
  read();
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].reason, GapReason::kQueueFull);
  EXPECT_EQ(gaps[0].error, 0);
  EXPECT_EQ(gaps[0].lost, (RecordTally{3, 3, 0, 0, 0, 0, 0}));
}

TEST_F(RecorderTest, InLockstepGivesUpOnADiskThatRefuses) {
  limitFileSize(fs::file_size(paths.log()));
  push(1);
  EXPECT_THROW(recorder->drain(), SessionException);
}

}  // namespace
}  // namespace raven2_trainer::runtime
