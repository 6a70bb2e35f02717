#include "raven2_trainer/recording/recorder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <utility>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/configuration_copy.h"
#include "support/rig.h"
#include "unit/session/record_values.h"

namespace raven2_trainer::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr Tick kQueue = decltype(RecordRings::ticks)::kCapacity;

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
      // Random numbers, which cannot be compressed: a limit of the file's size is reached.
      auto record = session::randomRecord<TickRecord>(random);
      record.model.tick = next_tick++;
      queues->tick_records.tryPush(record);
      queues->haptic_records.tryPush(HapticRecord{});
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
  SharedState* queues{&shared};  ///< that records are pushed to
  Random random{7};
  std::unique_ptr<Recorder> recorder;
  Tick next_tick{0};
  std::vector<Tick> ticks;
  std::vector<GapRecord> gaps;
};

TEST_F(RecorderTest, SaysInTheLogExactlyWhatAFullDiskCost) {
  push(100);
  recorder->drain(kSecond);
  // GIVEN a disk that is full for longer than the queues last
  limitFileSize(fs::file_size(paths.log()));
  push(10);
  recorder->drain(kSecond);
  EXPECT_EQ(shared.recorder.load().failing, 1);
  EXPECT_EQ(shared.recorder.load().error, EFBIG);
  push(kQueue + 952);
  recorder->drain(2 * kSecond);
  EXPECT_EQ(shared.recorder.load().lost, 2 * 962u);
  // WHEN there is room again
  limitFileSize(RLIM_INFINITY);
  recorder->drain(2 * kSecond + kSecond / 4);
  EXPECT_EQ(shared.recorder.load().failing, 1) << "not tried before its time";
  recorder->drain(3 * kSecond);
  EXPECT_EQ(shared.recorder.load().failing, 0);
  push(5);
  recorder->finish(SessionCounts{});
  // THEN all records are there except those that did not fit in the queues, and the log says so
  const session::LogSummary summary = read();
  EXPECT_TRUE(summary.clean);
  EXPECT_EQ(summary.bad_bytes, 0u);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].reason, GapReason::kNotWritten);
  EXPECT_EQ(gaps[0].error, EFBIG);
  EXPECT_EQ(gaps[0].lost, (RecordTally{962, 962, 0, 0, 0, 0, 0}));
  EXPECT_EQ(gaps[0].tick, kQueue + 99);
  ASSERT_EQ(ticks.size(), 100u + kQueue + 5u);
  EXPECT_EQ(ticks[kQueue + 99], kQueue + 99);
  EXPECT_EQ(ticks[kQueue + 100], kQueue + 100 + 962);
}

TEST_F(RecorderTest, CountsAsDroppedWhatTheDiskNeverTook) {
  push(100);
  recorder->drain(kSecond);
  push(1000);
  // GIVEN a disk with room for the end of the log, but not for the waiting records
  limitFileSize(fs::file_size(paths.log()) + 65536);
  recorder->finish(sharedCounts(shared));
  SessionCounts counts;
  session::LogVisitor visitor;
  visitor.counts = [&](const SessionCounts& read) { counts = read; };
  EXPECT_TRUE(session::readLog(paths.log(), visitor).clean);
  EXPECT_EQ(counts.records_dropped, 1000u + 1000u);
  for (const RingId ring : {RingId::kTickRecords, RingId::kHapticRecords}) {
    const RingCounts& records = counts.rings[static_cast<std::size_t>(ring)];
    EXPECT_EQ(records.pushed, 100u);
    EXPECT_EQ(records.taken, 100u);
    EXPECT_EQ(records.dropped, 1000u);
  }
}

TEST_F(RecorderTest, SaysThatItDidNotKeepUp) {
  push(kQueue + 3);
  recorder->drain(kSecond);
  recorder->finish(SessionCounts{});
  read();
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].reason, GapReason::kQueueFull);
  EXPECT_EQ(gaps[0].error, 0);
  EXPECT_EQ(gaps[0].lost, (RecordTally{3, 3, 0, 0, 0, 0, 0}));
}

TEST_F(RecorderTest, ATroubleThatCostNothingIsNotBlamedForLaterLosses) {
  push(10);
  recorder->drain(kSecond);
  limitFileSize(fs::file_size(paths.log()));
  push(10);
  recorder->drain(kSecond);
  ASSERT_EQ(shared.recorder.load().failing, 1);
  limitFileSize(RLIM_INFINITY);
  recorder->drain(3 * kSecond);
  ASSERT_EQ(shared.recorder.load().failing, 0);
  push(kQueue + 3);
  recorder->drain(4 * kSecond);
  recorder->finish(SessionCounts{});
  read();
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps[0].reason, GapReason::kQueueFull);
  EXPECT_EQ(gaps[0].error, 0);
}

TEST_F(RecorderTest, PutsWhatHappenedInAnExerciseAheadOfItsTick) {
  ExerciseRecord event;
  event.event.kind = ExerciseEventKind::kDropped;
  push(2);
  event.tick = 1;
  shared.exercise_records.tryPush(event);
  recorder->drain(kSecond);
  recorder->finish(SessionCounts{});
  std::string order;
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) { order += " t" + std::to_string(record.model.tick); };
  visitor.exercise = [&](const ExerciseRecord& record) {
    order += " e" + std::to_string(record.tick);
    EXPECT_EQ(record.event.kind, ExerciseEventKind::kDropped);
  };
  EXPECT_TRUE(session::readLog(paths.log(), visitor).clean);
  EXPECT_EQ(order, " e1 t0 t1");
}

TEST_F(RecorderTest, DescribesInTheHeaderWhatIsTrained) {
  config.exercise_name = "press";
  config.drill = "sudden_jump";
  config.trainee = "t1";
  config.curriculum = "basics";
  config.exercise.tracks.resize(2);
  config.exercise.tracks[0].steps.resize(2);
  config.exercise.tracks[0].steps[0].name = "lift";
  config.exercise.tracks[0].steps[1].name = "place";
  config.roles.objects.resize(1);
  config.roles.objects[0].name = "ring";
  const session::LogHeader header = logHeader(config, {}, "", paths);
  EXPECT_EQ(header.exercise, "press");
  EXPECT_EQ(header.drill, "sudden_jump");
  EXPECT_EQ(header.trainee, "t1");
  EXPECT_EQ(header.curriculum, "basics");
  EXPECT_EQ(header.step_names, (std::vector<std::vector<std::string>>{{"lift", "place"}, {}}));
  EXPECT_EQ(header.object_names, (std::vector<std::string>{"ring"}));
  EXPECT_EQ(header.motion_scale, config.console.scale);
  EXPECT_EQ(header.hand.mass, config.console.hand_mass);
  EXPECT_EQ(header.hand.stiffness, config.console.hand_stiffness);
  EXPECT_EQ(header.hand.damping, config.console.hand_damping);
  EXPECT_EQ(header.camera.name, config.render.live_camera);
  EXPECT_GT(header.camera.vertical_fov, 0.0);
  EXPECT_DOUBLE_EQ(header.camera.aspect * config.render.live_height, config.render.live_width);
}

/** Resimulation, scores and videos read the session's copy: it holds what ran, so its hashes differ from the files'. */
TEST_F(RecorderTest, TheCopyOfTheConfigurationHoldsWhatParametersOverride) {
  const std::string root = RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml";
  const TrainerConfig other = config::loadTrainerConfig(root, {}, {{"haptics/tolerance", "0.005", "a parameter"}});
  const session::LogHeader plain = logHeader(config, {}, "", paths);
  const session::LogHeader header = logHeader(other, {}, "", paths);
  EXPECT_NE(header.config_hash, plain.config_hash);
  EXPECT_EQ(header.tolerance, 0.005);
  const TrainerConfig read = config::loadTrainerConfig(session::checkConfiguration(paths, header));
  EXPECT_EQ(read.haptics.tolerance, 0.005);
  EXPECT_EQ(read.haptics.kp, config.haptics.kp);
  ASSERT_EQ(header.configuration.size(), plain.configuration.size());
  for (std::size_t i = 0; i < plain.configuration.size(); ++i) {
    const bool is_its_file = fs::path(plain.configuration[i].path).filename() == "haptics.yaml";
    EXPECT_EQ(header.configuration[i].fnv1a != plain.configuration[i].fnv1a, is_its_file)
        << plain.configuration[i].path;
  }
}

TEST_F(RecorderTest, OfTheFolderOfPlantsItCopiesThePlantsAlone) {
  const fs::path plants = fs::path(paths.directory) / "plants";
  fs::create_directories(plants / "old");
  fs::copy(config.virtual_raven.plants_folder + "/worn_tool.yaml", plants / "mine.yaml");
  fs::create_symlink("somebody@somewhere", plants / ".#mine.yaml");  // an editor's lock
  config.virtual_raven.plants_folder = plants.string();
  const session::LogHeader header = logHeader(config, {}, "", paths);
  const auto is_mine = [](const session::ConfigurationFile& file) {
    return fs::path(file.path).filename() == "mine.yaml";
  };
  EXPECT_EQ(std::count_if(header.configuration.begin(), header.configuration.end(), is_mine), 1);
}

/** A process whose ROS master hangs leaves without destructors: its log must be read as the whole one that it is. */
TEST_F(RecorderTest, AFinishedLogNeedsNoFlightRecorder) {
  session::FlightRecorder flight("/dev/shm");
  if (flight.description().rfind("none", 0) == 0) GTEST_SKIP() << flight.description();
  const auto queues = std::make_unique<SharedState>(flight.rings());
  recorder.reset();
  Recorder with_flight(config, {}, paths, "", queues.get(), &flight);
  queues->tick_records.tryPush(TickRecord{});
  ASSERT_TRUE(fs::exists(flight.description()));
  with_flight.drain();
  with_flight.finish(sharedCounts(*queues));
  EXPECT_FALSE(fs::exists(flight.description()));
  EXPECT_FALSE(fs::is_symlink(paths.directory + "/flight_recorder"));
  EXPECT_TRUE(read().clean);
  queues->tick_records.tryPush(TickRecord{});  // the memory is still there
}

/** With a full disk, the last records are still in the flight recorder, for a recovery. */
TEST_F(RecorderTest, ALogThatCannotBeFinishedKeepsItsFlightRecorder) {
  std::string file;
  {
    session::FlightRecorder flight("/dev/shm");
    if (flight.description().rfind("none", 0) == 0) GTEST_SKIP() << flight.description();
    file = flight.description();
    const auto surviving = std::make_unique<SharedState>(flight.rings());
    recorder.reset();
    Recorder with_flight(config, {}, paths, "", surviving.get(), &flight);
    limitFileSize(1);
    EXPECT_THROW(with_flight.finish(sharedCounts(*surviving)), SessionException);
  }
  EXPECT_TRUE(fs::remove(file));
}

/** A session with queues that survive the process: a batch may wait in them. */
class WaitingRecorderTest : public RecorderTest {
 protected:
  void SetUp() override {
    if (flight.description().rfind("none", 0) == 0) GTEST_SKIP() << flight.description();
    fs::remove(paths.log());
    queues = surviving.get();
    recorder = std::make_unique<Recorder>(config, std::vector<std::string>{}, paths, "", queues, &flight);
    size_ = fs::file_size(paths.log());
  }
  ~WaitingRecorderTest() override { recorder.reset(); }

  bool hasGrown() {
    const auto before = std::exchange(size_, fs::file_size(paths.log()));
    return size_ > before;
  }

  session::FlightRecorder flight{"/dev/shm"};
  std::unique_ptr<SharedState> surviving{std::make_unique<SharedState>(flight.rings())};

 private:
  std::uintmax_t size_{};
};

TEST_F(WaitingRecorderTest, WritesHalfASecondAtATime) {
  push(499);
  recorder->drain(kSecond);
  EXPECT_FALSE(hasGrown());
  push(1);
  recorder->drain(kSecond);
  EXPECT_TRUE(hasGrown());
  push(499);
  recorder->drain(kSecond);
  EXPECT_FALSE(hasGrown());
  EXPECT_EQ(sharedCounts(*queues).rings[static_cast<std::size_t>(RingId::kTickRecords)].taken, 500U);
  recorder->drain(kSecond, /*at_once=*/true);
  EXPECT_TRUE(hasGrown());
  recorder->finish(sharedCounts(*queues));
  read();
  EXPECT_EQ(ticks.size(), 999U);
}

TEST_F(WaitingRecorderTest, WritesBeforeAQueueIsMoreThanAThirdFull) {
  for (std::size_t i = 0; i + 1 < decltype(RecordRings::plans)::kCapacity / 3; ++i)
    queues->plan_records.tryPush(PlanRecord{});
  recorder->drain(kSecond);
  EXPECT_FALSE(hasGrown());
  queues->plan_records.tryPush(PlanRecord{});
  recorder->drain(kSecond);
  EXPECT_TRUE(hasGrown());
}

/** As the page on sessions promises: 2 s of ticks, 8192 contacts, 4096 events, on top of what waits for its batch. */
TEST_F(WaitingRecorderTest, HasRoomForTwoSecondsOfADiskThatRefuses) {
  limitFileSize(fs::file_size(paths.log()));
  push(499);
  recorder->drain(kSecond);
  ASSERT_EQ(queues->recorder.load().failing, 0) << "nothing is tried yet";
  push(2000);
  for (int i = 0; i < 8192 + 4095; ++i)
    queues->contact_records.tryPush(ContactRecord{});
  for (int i = 0; i < 4096 + 2047; ++i)
    queues->exercise_records.tryPush(ExerciseRecord{});
  recorder->drain(kSecond);
  EXPECT_EQ(queues->recorder.load().failing, 1);
  EXPECT_EQ(queues->recorder.load().lost, 0U);
  limitFileSize(RLIM_INFINITY);
  recorder->drain(2 * kSecond);
  EXPECT_EQ(queues->recorder.load().failing, 0);
  recorder->finish(sharedCounts(*queues));
  read();
  EXPECT_EQ(ticks.size(), 2499U);
  EXPECT_TRUE(gaps.empty());
}

/** "Written again" has to be true: after a refusal even a single record is tried. */
TEST_F(WaitingRecorderTest, AfterARefusalItSaysThatItWritesAgainOnlyOnceItDid) {
  limitFileSize(fs::file_size(paths.log()));
  push(1);
  recorder->drain(kSecond, /*at_once=*/true);
  ASSERT_EQ(queues->recorder.load().failing, 1);
  recorder->drain(2 * kSecond);
  EXPECT_EQ(queues->recorder.load().failing, 1);
  limitFileSize(RLIM_INFINITY);
  recorder->drain(3 * kSecond);
  EXPECT_EQ(queues->recorder.load().failing, 0);
  EXPECT_TRUE(hasGrown());
}

TEST_F(RecorderTest, InLockstepTheMetricsAreThoseOfTheLogInItsOrder) {
  for (int i = 0; i < 1200; ++i) {
    push(1);
    recorder->follow();
  }
  EXPECT_EQ(read().truncated_bytes, 0U);
  EXPECT_EQ(ticks.size(), 1000U) << "two batches";
  recorder->finish(sharedCounts(shared));
  std::string order;
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord&) { order += 't'; };
  visitor.haptic = [&](const HapticRecord&) { order += 'h'; };
  session::readLog(paths.log(), visitor);
  std::string expected;
  for (int i = 0; i < 1200; ++i)
    expected += "th";
  EXPECT_EQ(order, expected) << "as the ticks came, not kind by kind";
}

TEST_F(RecorderTest, InLockstepGivesUpOnADiskThatRefuses) {
  limitFileSize(fs::file_size(paths.log()));
  push(1);
  EXPECT_THROW(recorder->drain(), SessionException);
}

}  // namespace
}  // namespace raven2_trainer::recording
