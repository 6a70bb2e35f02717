#include "raven2_trainer/training/session_index.h"

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "gtest/gtest.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::training {
namespace {

namespace fs = std::filesystem;

class SessionIndex : public ::testing::Test {
 protected:
  SessionIndex() { fs::create_directories(folder_); }
  ~SessionIndex() override { fs::remove_all(folder_); }
  SessionIndex(const SessionIndex&) = delete;
  SessionIndex& operator=(const SessionIndex&) = delete;

  void write(const std::string& text) const { std::ofstream(path()) << text; }
  std::string path() const { return (folder_ / "index.json").string(); }

  fs::path folder_{fs::temp_directory_path() / ("index_test_" + std::to_string(::getpid()))};
};

IndexEntry makeEntry(const std::string& directory,
                     const std::string& start,
                     std::optional<bool> passed = true,
                     double time = 40.0) {
  IndexEntry entry;
  entry.directory = directory;
  entry.start_time_utc = start;
  entry.trainee = "kim-01";
  entry.exercise = "peg_transfer";
  entry.attempts = {{"done", passed, {{"time", time}, {"path", 812.25}}}};
  return entry;
}

TEST_F(SessionIndex, IsEmptyBeforeThereIsOne) {
  EXPECT_TRUE(readIndex(path()).empty());
}

TEST_F(SessionIndex, GivesBackWhatWasAddedInTheOrderOfTime) {
  addToIndex(path(), makeEntry("b", "2026-02-01T10:00:00Z", false));
  addToIndex(path(), makeEntry("c", "2026-01-01T10:00:00Z", std::nullopt));
  const std::vector<IndexEntry> index = readIndex(path());
  ASSERT_EQ(index.size(), 2u);
  EXPECT_EQ(index[0].directory, "c");
  EXPECT_EQ(index[0].attempts[0].passed, std::nullopt);
  EXPECT_EQ(index[1].start_time_utc, "2026-02-01T10:00:00Z");
  EXPECT_EQ(index[1].trainee, "kim-01");
  EXPECT_EQ(index[1].exercise, "peg_transfer");
  EXPECT_EQ(index[1].drill, "");
  EXPECT_EQ(index[1].attempts[0].status, "done");
  EXPECT_EQ(index[1].attempts[0].passed, false);
  EXPECT_EQ(index[1].attempts[0].metrics.at("path"), 812.25);
  EXPECT_FALSE(fs::exists(path() + ".part"));
}

TEST_F(SessionIndex, ReplacesTheEntryOfASessionScoredAgain) {
  addToIndex(path(), makeEntry("a", "2026-01-01T10:00:00Z", false, 90.0));
  addToIndex(path(), makeEntry("b", "2026-01-02T10:00:00Z"));
  addToIndex(path(), makeEntry("a", "2026-01-01T10:00:00Z", true, 50.0));
  const std::vector<IndexEntry> index = readIndex(path());
  ASSERT_EQ(index.size(), 2u);
  EXPECT_EQ(index[0].attempts[0].metrics.at("time"), 50.0);
}

TEST_F(SessionIndex, LosesNoEntryOfManyAtOnce) {
  constexpr int kWriters = 8, kEntries = 10;
  for (int writer = 0; writer < kWriters; ++writer) {
    if (::fork() != 0) continue;
    for (int i = 0; i < kEntries; ++i)
      addToIndex(path(), makeEntry(std::to_string(writer) + "_" + std::to_string(i), "2026-01-01T10:00:00Z"));
    ::_exit(0);
  }
  int status = 0;
  while (::wait(&status) > 0)
    EXPECT_EQ(status, 0);
  EXPECT_EQ(readIndex(path()).size(), static_cast<std::size_t>(kWriters * kEntries));
}

TEST_F(SessionIndex, RefusesWhatIsNoTraineesId) {
  for (const char* bad : {"", "Kim", "kim 1", "../kim", "k\xC3\xAFm", "a123456789012345678901234567890123"}) {
    IndexEntry entry = makeEntry("a", "2026-01-01T10:00:00Z");
    entry.trainee = bad;
    EXPECT_THROW(addToIndex(path(), entry), SessionException) << bad;
  }
  EXPECT_FALSE(fs::exists(path()));
  EXPECT_TRUE(isTraineeId("a"));
  EXPECT_TRUE(isTraineeId("0-_z5678901234567890123456789012"));  // 32
}

TEST_F(SessionIndex, LeavesAFileAloneThatIsNoIndex) {
  for (const char* bad : {"", "[]", "{\"version\": 2, \"sessions\": []}", "{\"version\": 1}",
                          "{\"version\": 1, \"sessions\": [{\"directory\": 5}]}", "{\"version\": 1, \"sessions\": ["}) {
    write(bad);
    EXPECT_THROW(addToIndex(path(), makeEntry("a", "2026-01-01T10:00:00Z")), SessionException) << bad;
    EXPECT_EQ(fs::file_size(path()), std::string(bad).size());
  }
}

TEST_F(SessionIndex, GivesATraineesAttemptsToACurriculum) {
  IndexEntry other = makeEntry("x", "2026-01-01T11:00:00Z");
  other.trainee = "lee";
  const std::vector<IndexEntry> index{makeEntry("a", "1", true), other, makeEntry("b", "2", std::nullopt)};
  const std::vector<CurriculumAttempt> attempts = attemptsOf(index, "kim-01");
  ASSERT_EQ(attempts.size(), 2u);
  EXPECT_TRUE(attempts[0].passed);
  EXPECT_FALSE(attempts[1].passed);  // not judged
  EXPECT_EQ(attempts[0].exercise, "peg_transfer");
}

}  // namespace
}  // namespace raven2_trainer::training
