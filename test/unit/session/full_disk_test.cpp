#include <sys/stat.h>

#include <cerrno>
#include <filesystem>

#include "log_file.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_log.h"
#include "session/record_frame.h"
#include "support/file_size_limit.h"

namespace raven2_trainer::session {
namespace {

using raven2_trainer::testing::FileSizeLimit;

std::uint64_t requestsIn(const std::string& path, LogSummary* summary) {
  std::uint64_t count = 0;
  LogVisitor visitor;
  visitor.request = [&count](const RequestRecord& record) { EXPECT_EQ(record.tick, static_cast<Tick>(count++)); };
  *summary = readLog(path, visitor);
  return count;
}

TEST(FullDisk, LeavesWholeRecordsAndIsTakenUpWhereItLeftOff) {
  const std::string path = scratchPath("full_disk.rlog");
  LogWriter log(path, LogHeader{});
  const auto write = [&log](Tick first, Tick last) {
    for (Tick tick = first; tick < last; ++tick)
      log.write(RequestRecord{tick, {}});
    return log.commit();
  };
  ASSERT_TRUE(write(0, 100));
  const LogPosition before = log.position();
  {
    // GIVEN room for half of the next batch
    const FileSizeLimit limit(before.size + 3000);
    EXPECT_FALSE(write(100, 200));
    EXPECT_EQ(log.error(), EFBIG);
    LogSummary summary;
    EXPECT_EQ(requestsIn(path, &summary), 100u);
    EXPECT_EQ(summary.bad_bytes + summary.truncated_bytes, 0u) << "the last record is whole";
    EXPECT_FALSE(write(100, 200)) << "and so it stays";
    EXPECT_EQ(log.position().next_number, before.next_number);
  }
  EXPECT_TRUE(write(100, 200));
  log.finish(SessionCounts{});
  LogSummary summary;
  EXPECT_EQ(requestsIn(path, &summary), 200u);
  EXPECT_TRUE(summary.clean);
  EXPECT_EQ(summary.bad_bytes, 0u);
}

TEST(FullDisk, KeepsRoomForTheLastRecordAndGivesItBackInTheEnd) {
  const std::string path = scratchPath("reserve.rlog");
  LogWriter log(path, LogHeader{});
  const auto allocated = [&path] {
    struct stat status {};
    stat(path.c_str(), &status);
    return static_cast<std::uint64_t>(status.st_blocks) * 512;
  };
  if (allocated() < (1U << 20U)) GTEST_SKIP() << "this file system cannot allocate ahead";
  EXPECT_GE(allocated(), std::filesystem::file_size(path) + (1U << 20U));
  log.finish(SessionCounts{});
  EXPECT_LT(allocated(), std::filesystem::file_size(path) + (1U << 16U));
}

TEST(FullDisk, IsNotTakenUpInAFileThatSomebodyCut) {
  const std::string path = scratchPath("cut_by_others.rlog");
  LogWriter log(path, LogHeader{});
  log.write(TickRecord{});
  ASSERT_TRUE(log.commit());
  {
    const FileSizeLimit limit(log.position().size);
    log.write(TickRecord{});
    ASSERT_FALSE(log.commit());
  }
  std::filesystem::resize_file(path, 100);
  log.write(TickRecord{});
  EXPECT_FALSE(log.commit()) << "records behind a hole would look like damage";
}

/** Numbers of all records behind the header. */
std::vector<std::uint64_t> numbersIn(const std::string& path) {
  const Bytes bytes = readBytes(path);
  std::vector<std::uint64_t> numbers;
  for (std::size_t at = 0; at + kFrameHeaderSize <= bytes.size();) {
    const FrameHeader header = decodeFrameHeader(bytes.data() + at);
    numbers.push_back(header.number);
    at += kFrameHeaderSize + header.length + kCrcSize;
  }
  return numbers;
}

TEST(FullDisk, LeavesNoGapInTheNumbersOfTheRecordsAroundIt) {
  const std::string path = scratchPath("numbers.rlog");
  LogWriter log(path, LogHeader{});
  for (int failure = 0; failure < 3; ++failure) {
    log.write(RequestRecord{});
    ASSERT_TRUE(log.commit());
    const LogPosition before = log.position();
    {
      const FileSizeLimit limit(before.size + 10);
      log.write(RequestRecord{});
      log.write(RequestRecord{});
      ASSERT_FALSE(log.commit());
    }
    EXPECT_EQ(log.position().size, before.size);
    EXPECT_EQ(log.position().next_number, before.next_number);
  }
  log.finish(SessionCounts{});
  EXPECT_EQ(numbersIn(path), (std::vector<std::uint64_t>{0, 1, 2, 3, 4})) << "header, three requests, counters";
  EXPECT_EQ(log.position().next_number, 5U);
  EXPECT_EQ(readLog(path, {}).records, 4U);
}

TEST(FullDisk, CutsOffWhatAFailedPieceLeftBehind) {
  const std::string path = scratchPath("left_behind.rlog");
  LogWriter log(path, LogHeader{});
  log.write(RequestRecord{});
  ASSERT_TRUE(log.commit());
  {
    const FileSizeLimit limit(log.position().size);
    log.write(RequestRecord{});
    ASSERT_FALSE(log.commit());
  }
  std::ofstream(path, std::ios::app) << std::string(5000, 'x');  // as if the cut had failed, too
  log.write(RequestRecord{7, {}});
  ASSERT_TRUE(log.commit());
  EXPECT_EQ(std::filesystem::file_size(path), log.position().size) << "while the session runs, too";
  log.finish(SessionCounts{});
  const LogSummary summary = readLog(path, {});
  EXPECT_EQ(summary.records, 3U);
  EXPECT_EQ(summary.bad_bytes + summary.truncated_bytes, 0U);
  EXPECT_TRUE(summary.clean);
}

TEST(FullDisk, LetsALogBeFinishedOnceThereIsRoom) {
  const std::string path = scratchPath("finished_later.rlog");
  LogWriter log(path, LogHeader{});
  {
    const FileSizeLimit limit(log.position().size);
    EXPECT_THROW(log.finish(SessionCounts{}), SessionException);
  }
  EXPECT_FALSE(readLog(path, {}).clean);
  log.finish(SessionCounts{});
  EXPECT_TRUE(readLog(path, {}).clean);
}

}  // namespace
}  // namespace raven2_trainer::session
