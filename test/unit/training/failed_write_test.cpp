#include <filesystem>
#include <fstream>
#include <iterator>

#include "gtest/gtest.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/training/session_index.h"
#include "raven2_trainer/training/session_metrics.h"
#include "raven2_trainer/training/session_score.h"
#include "support/file_size_limit.h"
#include "support/scratch_path.h"

// A disk that is full leaves the file that was there, whole, and the write says so.

namespace raven2_trainer::training {
namespace {

using raven2_trainer::testing::FileSizeLimit;
using raven2_trainer::testing::scratchPath;

std::string textOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/** Writes once, then again onto a disk with room for 20 bytes, then again. */
template <typename Write>
void expectWholeFile(const std::string& path, const Write& write) {
  std::filesystem::remove(path);
  write(1);
  const std::string before = textOf(path);
  ASSERT_GT(before.size(), 20U);
  {
    const FileSizeLimit limit(20);
    EXPECT_THROW(write(2), SessionException);
  }
  EXPECT_EQ(textOf(path), before);
  write(2);
  EXPECT_NE(textOf(path), before) << "or nothing was to be written";
}

SessionMetrics makeMetrics(int n) {
  SessionMetrics metrics;
  metrics.ticks = static_cast<std::uint64_t>(n);
  metrics.injections_beyond = static_cast<std::uint64_t>(n);
  return metrics;
}

TEST(FailedWrite, KeepsTheMetrics) {
  const std::string path = scratchPath("kept_metrics.json");
  expectWholeFile(path, [&](int n) { writeMetrics(path, makeMetrics(n)); });
}

TEST(FailedWrite, KeepsTheFaults) {
  const std::string path = scratchPath("kept_faults.json");
  expectWholeFile(path, [&](int n) { writeFaults(path, makeMetrics(n)); });
}

TEST(FailedWrite, KeepsTheMetricsWhoseFramesWereToBeSet) {
  const std::string path = scratchPath("kept_frames.json");
  expectWholeFile(path, [&](int n) {
    if (n == 1) writeMetrics(path, makeMetrics(1));
    setFrames(path, static_cast<std::uint64_t>(n));
  });
}

TEST(FailedWrite, KeepsTheScore) {
  const std::string path = scratchPath("kept_score.json");
  expectWholeFile(path, [&](int n) {
    SessionScore score;
    score.hazards_beyond = static_cast<std::uint64_t>(n);
    const ScoreSettings settings;
    writeScore(path, score, settings);
  });
}

TEST(FailedWrite, KeepsTheIndexAndLetsTheNextOneIn) {
  const std::string path = scratchPath("kept_index.json");
  expectWholeFile(path, [&](int n) {
    IndexEntry entry;
    entry.directory = std::to_string(n);
    entry.trainee = "ann";
    addToIndex(path, entry);
  });
  EXPECT_EQ(readIndex(path).size(), 2U);
}

}  // namespace
}  // namespace raven2_trainer::training
