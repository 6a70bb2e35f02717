#include "raven2_trainer/session/recovery.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "log_file.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/session/flight_recorder.h"
#include "raven2_trainer/session/session_log.h"
#include "session/flight_file.h"
#include "support/effort.h"

namespace raven2_trainer::session {
namespace {

namespace fs = std::filesystem;

constexpr int kQueue = decltype(RecordRings::ticks)::kCapacity;

/** A session whose ticks are numbered, with a recorder that can be killed between any two steps of its work. */
class Session {
 public:
  explicit Session(const std::string& name) : paths{scratchPath(name) + "/sessions/0"} {
    fs::remove_all(scratchPath(name));
    fs::create_directories(paths.directory);
    flight = std::make_unique<FlightRecorder>("/dev/shm");
    log = std::make_unique<LogWriter>(paths.log(), LogHeader{});
    flight->attach(paths);
    flight->checkpoint({log->position(), {}, {}});
  }
  ~Session() {
    fs::remove(flight_file_);
    fs::remove_all(paths.directory);
  }

  void push(int count) {
    for (int i = 0; i < count; ++i) {
      TickRecord record;
      record.model.tick = next_tick++;
      flight->rings()->ticks.tryPush(record);
    }
  }
  void collect() {
    auto& ring = flight->rings()->ticks;
    heads[0] = ring.tail();
    for (std::uint64_t i = ring.head(); i < heads[0]; ++i)
      log->write(ring.at(i));
  }
  void commit() { ASSERT_TRUE(log->commit()); }
  void checkpoint() { flight->checkpoint({log->position(), heads, {}}); }
  void release() { flight->rings()->ticks.release(heads[0]); }
  void record() {
    collect();
    commit();
    checkpoint();
    release();
  }
  /** Leaves the files as a SIGKILL does: the flight recorder's as it is, the log without its uncommitted part. */
  void kill() {
    flight_file_ = flight->description();
    flight->keep();
    const std::uint64_t written = fs::file_size(paths.log());
    log.reset();
    flight.reset();
    fs::resize_file(paths.log(), written);
  }
  /** Of the log. */
  std::vector<Tick> ticks() const {
    std::vector<Tick> found;
    LogVisitor visitor;
    visitor.tick = [&](const TickRecord& record) { found.push_back(record.model.tick); };
    summary = readLog(paths.log(), visitor);
    return found;
  }
  std::vector<Tick> all() const {
    std::vector<Tick> numbers;
    for (Tick i = 0; i < next_tick; ++i)
      numbers.push_back(i);
    return numbers;
  }
  std::string flightFile() const { return flight_file_; }

  SessionPaths paths;
  std::unique_ptr<FlightRecorder> flight;
  std::unique_ptr<LogWriter> log;
  RecordTally heads{};
  Tick next_tick{0};
  mutable LogSummary summary;

 private:
  std::string flight_file_;
};

#define SKIP_WITHOUT_TMPFS(session) \
  if ((session).flight->description().rfind("none", 0) == 0) GTEST_SKIP() << (session).flight->description()

TEST(Recovery, AFlightFileThatAKilledRecoveryLeftIsRemovedByTheNext) {
  Session session("left_behind");
  SKIP_WITHOUT_TMPFS(session);
  session.push(100);
  session.record();
  session.kill();
  const std::string kept = session.flightFile() + ".kept";
  fs::copy_file(session.flightFile(), kept);
  ASSERT_EQ(recoverSession(session.paths, {}).status, RecoveryStatus::kRecovered);
  fs::rename(kept, session.flightFile());  // killed before this step
  fs::create_symlink(session.flightFile(), session.paths.flight());
  const std::vector<std::string> found = findUnfinishedSessions(fs::path(session.paths.directory).parent_path(), 10);
  EXPECT_EQ(found, std::vector<std::string>{session.paths.directory});
  EXPECT_EQ(recoverSession(session.paths, {}).status, RecoveryStatus::kNothingToDo);
  EXPECT_FALSE(fs::exists(session.flightFile()));
  EXPECT_FALSE(fs::is_symlink(fs::symlink_status(session.paths.flight())));
  EXPECT_EQ(session.ticks(), session.all());
}

TEST(Recovery, ARecoveryThatWasKilledBehindItsLastRecordIsDoneAgain) {
  for (const bool has_flight : {true, false}) {
    Session session("killed_recovery");
    SKIP_WITHOUT_TMPFS(session);
    session.push(100);
    session.record();
    session.push(30);
    session.kill();
    const std::string kept = session.flightFile() + ".kept";
    fs::copy_file(session.flightFile(), kept);
    ASSERT_EQ(recoverSession(session.paths, {}).status, RecoveryStatus::kRecovered);
    const std::vector<Tick> whole = session.ticks();
    ASSERT_EQ(whole, session.all());
    fs::remove(session.paths.recovered());  // killed before this was written
    if (has_flight) {
      fs::rename(kept, session.flightFile());
      fs::create_symlink(session.flightFile(), session.paths.flight());
    } else {
      fs::remove(kept);
    }
    EXPECT_EQ(findUnfinishedSessions(fs::path(session.paths.directory).parent_path(), 10).size(), 1U);
    EXPECT_EQ(recoverSession(session.paths, {}).status, RecoveryStatus::kRecovered);
    EXPECT_TRUE(fs::exists(session.paths.recovered()));
    EXPECT_EQ(session.ticks(), whole);
    EXPECT_TRUE(session.summary.recovered);
    std::ofstream(session.paths.metrics()) << "{}";
    EXPECT_EQ(findUnfinishedSessions(fs::path(session.paths.directory).parent_path(), 10).size(), 0U);
  }
}

TEST(Recovery, MissesAndDoublesNothingWhereverTheRecorderWasKilled) {
  for (int step = 0; step <= 4; ++step) {
    Session session("killed");
    SKIP_WITHOUT_TMPFS(session);
    session.push(100);
    session.record();
    session.push(50);
    if (step >= 1) session.collect();
    if (step >= 2) session.commit();
    if (step >= 3) session.checkpoint();
    if (step >= 4) session.release();
    session.push(7);
    session.kill();
    EXPECT_TRUE(isUnclean(session.paths));
    EXPECT_FALSE(isBeingWritten(session.paths)) << "no process writes it any longer";
    const Recovery done = recoverSession(session.paths);
    EXPECT_EQ(done.status, RecoveryStatus::kRecovered);
    EXPECT_EQ(tallyTotal(done.recovered), step >= 3 ? 7u : 57u) << "killed after step " << step;
    EXPECT_EQ(session.ticks(), session.all()) << "killed after step " << step;
    EXPECT_TRUE(session.summary.recovered);
    EXPECT_FALSE(session.summary.clean);
    EXPECT_EQ(session.summary.bad_bytes + session.summary.truncated_bytes, 0u);
    EXPECT_FALSE(isUnclean(session.paths));
    EXPECT_FALSE(fs::exists(session.flightFile()));
    EXPECT_FALSE(fs::is_symlink(session.paths.flight()));
  }
}

TEST(Recovery, CutsAHalfWrittenBatch) {
  Session session("half");
  SKIP_WITHOUT_TMPFS(session);
  session.push(40);
  session.record();
  const std::uint64_t whole = fs::file_size(session.paths.log());
  session.push(40);
  session.collect();
  session.commit();
  const std::uint64_t size = fs::file_size(session.paths.log());
  session.kill();
  fs::resize_file(session.paths.log(), (whole + size) / 2);
  const Recovery done = recoverSession(session.paths);
  EXPECT_GT(done.cut_bytes, 0u);
  EXPECT_EQ(session.ticks(), session.all());
  EXPECT_EQ(session.summary.bad_bytes, 0u);
}

TEST(Recovery, CanBeKilledItselfAndBegunAgain) {
  Session session("twice");
  SKIP_WITHOUT_TMPFS(session);
  session.push(30);
  session.record();
  session.push(10);
  session.kill();
  const Bytes log = readBytes(session.paths.log());
  const Bytes flight = readBytes(session.flightFile());
  recoverSession(session.paths);
  const Bytes recovered = readBytes(session.paths.log());
  for (const std::size_t cut : {log.size() + 1, log.size() + 5000, recovered.size() - 1}) {
    // GIVEN a recovery that was killed when so much was written
    writeBytes(session.paths.log(), Bytes(recovered.begin(), recovered.begin() + static_cast<std::ptrdiff_t>(cut)));
    fs::remove(session.paths.recovered());
    writeBytes(session.flightFile(), flight);
    fs::remove(session.paths.flight());
    fs::create_symlink(session.flightFile(), session.paths.flight());
    recoverSession(session.paths);
    EXPECT_EQ(session.ticks(), session.all()) << cut;
    EXPECT_TRUE(session.summary.recovered);
  }
}

TEST(Recovery, TellsWhatTheQueuesCouldNotHold) {
  Session session("full_queue");
  SKIP_WITHOUT_TMPFS(session);
  session.push(kQueue + 13);
  session.kill();
  recoverSession(session.paths);
  RecordTally lost{};
  LogVisitor visitor;
  visitor.gap = [&](const GapRecord& gap) {
    lost = gap.lost;
    EXPECT_EQ(gap.reason, GapReason::kQueueFull);
    EXPECT_EQ(gap.tick, kQueue - 1);
  };
  readLog(session.paths.log(), visitor);
  EXPECT_EQ(lost, (RecordTally{13, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(session.ticks().size(), static_cast<std::size_t>(kQueue));
}

TEST(Recovery, SaysBehindWhichTickOfTheLogRecordsAreMissing) {
  Session session("gap_behind_the_log");
  SKIP_WITHOUT_TMPFS(session);
  session.push(10);
  session.record();
  auto& contacts = session.flight->rings()->contacts;
  while (contacts.dropped() == 0)
    contacts.tryPush(ContactRecord{});
  session.kill();
  recoverSession(session.paths);
  std::vector<Tick> gaps;
  LogVisitor visitor;
  visitor.gap = [&](const GapRecord& gap) { gaps.push_back(gap.tick); };
  readLog(session.paths.log(), visitor);
  EXPECT_EQ(gaps, (std::vector<Tick>{9}));
}

TEST(Recovery, LeavesALogWithALivingWriterAlone) {
  Session session("alive");
  session.push(5);
  EXPECT_EQ(recoverSession(session.paths).status, RecoveryStatus::kRunning);
  EXPECT_TRUE(isBeingWritten(session.paths));
  EXPECT_TRUE(findUnfinishedSessions(session.paths.directory + "/..", 10).empty());
  session.record();
  session.log->finish(SessionCounts{});
  EXPECT_FALSE(isUnclean(session.paths));
  EXPECT_FALSE(isBeingWritten(session.paths)) << "it has its end";
  EXPECT_EQ(recoverSession(session.paths).status, RecoveryStatus::kNothingToDo);
}

TEST(Recovery, WorksWithTheLogAloneAndFindsTheNewestSessions) {
  Session session("log_alone");
  session.push(20);
  session.record();
  session.push(20);
  session.kill();
  if (!session.flightFile().empty()) fs::remove(session.flightFile());
  const auto found = findUnfinishedSessions(session.paths.directory + "/..", 10);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(fs::equivalent(found[0], session.paths.directory));
  EXPECT_EQ(recoverSession(session.paths).status, RecoveryStatus::kRecovered);
  EXPECT_EQ(session.ticks().size(), 20u);
  EXPECT_TRUE(session.summary.recovered);
}

TEST(Recovery, WithoutMetricsIsNotDoneAndCanBeGivenUp) {
  Session session("no_metrics");
  session.push(2000);
  session.record();
  session.kill();
  if (!session.flightFile().empty()) fs::remove(session.flightFile());
  EXPECT_EQ(recoverSession(session.paths, [] { return true; }).status, RecoveryStatus::kCancelled);
  EXPECT_TRUE(isUnclean(session.paths));
  EXPECT_FALSE(lacksMetrics(session.paths));
  // GIVEN a recovery that was killed, or ended, before it came to the metrics
  EXPECT_EQ(recoverSession(session.paths).status, RecoveryStatus::kRecovered);
  EXPECT_FALSE(isUnclean(session.paths));
  // THEN the session is still found, until they are there
  EXPECT_TRUE(lacksMetrics(session.paths));
  const std::string parent = session.paths.directory + "/..";
  EXPECT_EQ(findUnfinishedSessions(parent, 10).size(), 1u);
  std::ofstream(session.paths.metrics()) << "{}";
  EXPECT_TRUE(findUnfinishedSessions(parent, 10).empty());
}

TEST(Recovery, WithoutMetricsACompleteLogIsNotDoneEither) {
  Session session("killed_before_metrics");
  session.push(10);
  session.record();
  session.log->finish(SessionCounts{});
  EXPECT_FALSE(lacksMetrics(session.paths)) << "its writer may be about to write them";
  session.kill();
  EXPECT_EQ(recoverSession(session.paths).status, RecoveryStatus::kNothingToDo);
  EXPECT_TRUE(lacksMetrics(session.paths));
  const std::string parent = session.paths.directory + "/..";
  EXPECT_EQ(findUnfinishedSessions(parent, 10).size(), 1u);
  std::ofstream(session.paths.metrics()) << "{}";
  EXPECT_TRUE(findUnfinishedSessions(parent, 10).empty());
}

TEST(Recovery, GivesIntactRecordsOnlyWhateverStandsInTheFlightRecorder) {
  Session session("garbage");
  SKIP_WITHOUT_TMPFS(session);
  session.push(10);
  session.record();
  session.push(300);
  session.kill();
  const Bytes log = readBytes(session.paths.log());
  const Bytes flight = readBytes(session.flightFile());
  const std::string link = session.flightFile();
  Random random(2017);
  const auto checkpoints = reinterpret_cast<std::size_t>(&reinterpret_cast<FlightFile*>(0x1000)->rings) - 0x1000;
  for (int i = 0; i < raven2_trainer::testing::effort(60, 1000); ++i) {
    Bytes bytes = flight;
    for (std::uint32_t n = 0; n < 1 + random.next() % 20; ++n) {
      // a third of the changes in the head, the rest in the records
      const std::size_t span = random.next() % 3 == 0 ? checkpoints : checkpoints + 400 * sizeof(TickRecord);
      bytes[random.next() % span] ^= static_cast<std::uint8_t>(1U << (random.next() % 8));
    }
    if (i % 10 == 9) bytes.resize(random.next() % bytes.size());
    writeBytes(session.paths.log(), log);
    writeBytes(link, bytes);
    fs::remove(session.paths.recovered());
    fs::remove(session.paths.flight());
    fs::create_symlink(link, session.paths.flight());
    const Recovery done = recoverSession(session.paths);
    ASSERT_EQ(done.status, RecoveryStatus::kRecovered);
    const std::vector<Tick> ticks = session.ticks();
    ASSERT_EQ(session.summary.bad_bytes, 0u);
    for (std::size_t k = 1; k < ticks.size(); ++k)
      ASSERT_LT(ticks[k - 1], ticks[k]);
    // each record is there or counted as lost; without a usable flight recorder the log's records stay
    ASSERT_EQ(ticks.size() + done.lost[0], done.flight_recorder == "used" ? 310u : 10u) << done.flight_recorder;
  }
}

/** Changes one byte of the newest checkpoint in the flight recorder's file, as a kill in the middle of it may. */
void tearNewestCheckpoint(const std::string& path) {
  Bytes bytes = readBytes(path);
  auto file = std::make_unique<FlightFile>();
  std::memcpy(static_cast<void*>(file.get()), bytes.data(), sizeof(FlightFile));
  const SealedCheckpoint* newest = newestCheckpoint(*file);
  ASSERT_NE(newest, nullptr);
  const auto offset = static_cast<std::size_t>(reinterpret_cast<const char*>(&newest->checkpoint) -
                                               reinterpret_cast<const char*>(file.get()));
  bytes[offset] ^= 1U;
  writeBytes(path, bytes);
}

TEST(Recovery, GoesOnAtTheCheckpointBeforeATornOne) {
  Session session("torn_checkpoint");
  SKIP_WITHOUT_TMPFS(session);
  for (int i = 0; i < 3; ++i) {
    session.push(20);
    session.record();
  }
  session.push(5);
  session.kill();
  tearNewestCheckpoint(session.flightFile());
  const Recovery done = recoverSession(session.paths);
  EXPECT_EQ(done.flight_recorder, "used");
  EXPECT_EQ(tallyTotal(done.recovered), 25u) << "the records of the torn checkpoint are written again";
  EXPECT_EQ(session.ticks(), session.all());
}

/** As after a loss of power: the end of the log never came to the disk. */
TEST(Recovery, GoesOnAtTheLastIntactRecordOfALogThatEndsBeforeItsCheckpoint) {
  Session session("short_log");
  SKIP_WITHOUT_TMPFS(session);
  session.push(10);  // too few for a chunk, which would be lost as a whole
  session.record();
  session.push(10);
  session.kill();
  fs::resize_file(session.paths.log(), fs::file_size(session.paths.log()) - 100);  // a part of the 10th
  const Recovery done = recoverSession(session.paths);
  EXPECT_EQ(done.status, RecoveryStatus::kRecovered);
  std::vector<Tick> expected = session.all();
  expected.erase(expected.begin() + 9);
  EXPECT_EQ(session.ticks(), expected);
  EXPECT_EQ(session.summary.bad_bytes, 0u);
}

/** Some records had no room in the queue, and changed bytes destroyed others. */
TEST(Recovery, AddsUpWhatWasLostForDifferentReasons) {
  Session session("two_losses");
  SKIP_WITHOUT_TMPFS(session);
  session.push(kQueue + 3);
  session.kill();
  auto file = std::make_unique<FlightFile>();
  Bytes bytes = readBytes(session.flightFile());
  std::memcpy(static_cast<void*>(file.get()), bytes.data(), sizeof(FlightFile));
  using Slot = std::decay_t<decltype(file->rings.ticks)>::Slot;
  const auto* slots = static_cast<const Slot*>(file->rings.ticks.slots());
  for (const std::size_t i : {5U, 900U})
    bytes[static_cast<std::size_t>(reinterpret_cast<const char*>(&slots[i]) -
                                   reinterpret_cast<const char*>(file.get()))] ^= 1U;
  writeBytes(session.flightFile(), bytes);
  const Recovery done = recoverSession(session.paths);
  EXPECT_EQ(done.lost[0], 5U);
  EXPECT_EQ(done.recovered[0], kQueue - 2U);
  EXPECT_EQ(session.ticks().size(), kQueue - 2U);
}

TEST(Recovery, TakesNothingFromAFlightRecorderOfAnotherLog) {
  Session session("another_log");
  SKIP_WITHOUT_TMPFS(session);
  session.push(10);
  session.record();
  session.push(10);
  session.kill();
  const std::string copy = session.paths.log() + ".copy";
  fs::copy_file(session.paths.log(), copy);  // the same bytes in another file
  fs::rename(copy, session.paths.log());
  const Recovery done = recoverSession(session.paths);
  EXPECT_EQ(done.flight_recorder, "belongs to another log");
  EXPECT_EQ(session.ticks().size(), 10u);
  EXPECT_TRUE(fs::exists(session.flightFile())) << "it is not ours to remove";
}

TEST(Recovery, CountsAsLostWhatNoGapRecordToldYet) {
  Session session("told_losses");
  SKIP_WITHOUT_TMPFS(session);
  session.push(kQueue + 13);
  session.collect();
  session.commit();
  RecordTally told{};
  told[0] = session.flight->rings()->ticks.dropped();
  ASSERT_EQ(told[0], 13u);
  session.flight->checkpoint({session.log->position(), session.heads, told});
  session.release();
  session.push(kQueue + 4);
  session.kill();
  const Recovery done = recoverSession(session.paths);
  EXPECT_EQ(done.lost[0], 4u);
}

/** Sessions of a folder, each with a log that nobody ended, written one after the other. */
std::vector<std::string> unfinishedSessions(const std::string& parent, int count) {
  fs::remove_all(parent);
  std::vector<std::string> directories;
  for (int i = 0; i < count; ++i) {
    const SessionPaths paths{parent + "/" + std::to_string((i * 2) % count)};  // the names are in another order
    fs::create_directories(paths.directory);
    { LogWriter log(paths.log(), LogHeader{}); }
    fs::last_write_time(paths.log(), fs::file_time_type::clock::now() - std::chrono::hours(24 * (count - i)));
    directories.push_back(paths.directory);
  }
  return directories;
}

TEST(Recovery, BeginsWithTheNewestSessionsAndStopsAtTheLimit) {
  const std::string parent = scratchPath("newest");
  std::vector<std::string> expected = unfinishedSessions(parent, 5);
  std::reverse(expected.begin(), expected.end());
  EXPECT_EQ(findUnfinishedSessions(parent, 10), expected);
  expected.resize(2);
  EXPECT_EQ(findUnfinishedSessions(parent, 2), expected);
  EXPECT_TRUE(findUnfinishedSessions(parent + "/none", 2).empty());
  fs::remove_all(parent);
}

/** recovered.json, by its keys. */
nlohmann::json noteOf(const SessionPaths& paths) {
  const Bytes bytes = readBytes(paths.recovered());
  return nlohmann::json::parse(bytes.begin(), bytes.end());
}

TEST(Recovery, NotesWhatItFound) {
  Session session("noted");
  SKIP_WITHOUT_TMPFS(session);
  session.push(30);
  session.record();
  const auto checkpoint = fs::file_size(session.paths.log());
  session.push(kQueue + 6);
  session.collect();
  session.commit();
  const auto behind = fs::file_size(session.paths.log()) - checkpoint;
  session.kill();
  const Recovery done = recoverSession(session.paths);
  const nlohmann::json note = noteOf(session.paths);
  EXPECT_EQ(note.at("ended"), "unclean");
  EXPECT_EQ(note.at("log"), "complete");
  EXPECT_EQ(note.at("flight_recorder"), "used");
  EXPECT_EQ(note.at("records_recovered").at("tick"), kQueue);
  EXPECT_EQ(note.at("records_recovered").at("haptic"), 0);
  EXPECT_EQ(note.at("records_lost").at("tick"), 6);
  EXPECT_EQ(note.at("cut_bytes"), done.cut_bytes);
  EXPECT_EQ(done.cut_bytes, behind) << "what was written behind the checkpoint";
  EXPECT_GT(behind, 0U);
}

TEST(FlightRecorder, IsPlainMemoryWhereThereIsNoTmpfs) {
  for (const char* folder : {"none", "/proc", "/no/such/folder"}) {
    FlightRecorder flight(folder);
    EXPECT_EQ(flight.description().rfind("none: ", 0), 0u) << flight.description();
    EXPECT_TRUE(flight.rings()->ticks.tryPush(TickRecord{}));
  }
}

TEST(FlightRecorder, RemovesItsFileInTheEnd) {
  std::string file;
  {
    Session session("removed");
    SKIP_WITHOUT_TMPFS(session);
    file = session.flight->description();
    struct stat status {};
    ASSERT_EQ(stat(file.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0600U);
    session.flight.reset();
    EXPECT_FALSE(fs::is_symlink(session.paths.flight()));
  }
  EXPECT_FALSE(fs::exists(file));
}

}  // namespace
}  // namespace raven2_trainer::session
