#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>
#include <filesystem>

#include "log_file.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {
namespace {

/** A disk that is full beyond so many bytes of any one file, for the life of this object. */
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::uint64_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

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

}  // namespace
}  // namespace raven2_trainer::session
