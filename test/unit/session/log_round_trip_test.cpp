#include <filesystem>

#include "log_file.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_log.h"
#include "record_values.h"
#include "support/allocation_counter.h"

namespace raven2_trainer::session {
namespace {

/** All records of a log, in file order of each kind. */
struct Contents {
  std::vector<std::vector<std::uint64_t>> values;
  LogVisitor visitor() {
    LogVisitor v;
    v.tick = [this](const TickRecord& r) { values.push_back(valuesOf(r)); };
    v.haptic = [this](const HapticRecord& r) { values.push_back(valuesOf(r)); };
    v.command = [this](const CommandRecord& r) { values.push_back(valuesOf(r)); };
    v.request = [this](const RequestRecord& r) { values.push_back(valuesOf(r)); };
    v.plan = [this](const PlanRecord& r) { values.push_back(valuesOf(r)); };
    v.faults = [this](const FaultRecord& r) { values.push_back(valuesOf(r)); };
    v.fault_change = [this](const FaultChangeRecord& r) { values.push_back(valuesOf(r)); };
    v.execution = [this](const ExecutionRecord& r) { values.push_back(valuesOf(r)); };
    v.exercise = [this](const ExerciseRecord& r) { values.push_back(valuesOf(r)); };
    v.contact = [this](const ContactRecord& r) { values.push_back(valuesOf(r)); };
    v.gap = [this](const GapRecord& r) { values.push_back(valuesOf(r)); };
    v.counts = [this](const SessionCounts& r) { values.push_back(valuesOf(r)); };
    return v;
  }
};

template <typename T>
void writeRandom(LogWriter* log, Random& random, Contents* expected) {
  const T record = randomRecord<T>(random);
  expected->values.push_back(valuesOf(record));
  log->write(record);
}

/** `rounds` random records of every kind in random order, and the counters. */
Contents writeRandomLog(const std::string& path, std::uint64_t seed, int rounds) {
  Random random(seed);
  Contents expected;
  LogWriter log(path, LogHeader{});
  for (int i = 0; i < rounds; ++i) {
    switch (random.next() % 11) {
      case 0:
        writeRandom<TickRecord>(&log, random, &expected);
        break;
      case 1:
        writeRandom<HapticRecord>(&log, random, &expected);
        break;
      case 2:
        writeRandom<CommandRecord>(&log, random, &expected);
        break;
      case 3:
        writeRandom<ContactRecord>(&log, random, &expected);
        break;
      case 4:
        writeRandom<RequestRecord>(&log, random, &expected);
        break;
      case 5:
        writeRandom<FaultRecord>(&log, random, &expected);
        break;
      case 6:
        writeRandom<FaultChangeRecord>(&log, random, &expected);
        break;
      case 7:
        writeRandom<GapRecord>(&log, random, &expected);
        break;
      case 8:
        writeRandom<ExecutionRecord>(&log, random, &expected);
        break;
      case 9:
        writeRandom<ExerciseRecord>(&log, random, &expected);
        break;
      default:
        writeRandom<PlanRecord>(&log, random, &expected);
        break;
    }
  }
  const auto counts = randomRecord<SessionCounts>(random);
  expected.values.push_back(valuesOf(counts));
  log.finish(counts);
  return expected;
}

#ifdef RAVEN2_COUNTS_ALLOCATIONS
TEST(SessionLog, TakesNoMemoryForABatchThatRoomWasTakenFor) {
  const std::string path = scratchPath("reserved.rlog");
  LogWriter log(path, LogHeader{});
  log.write(CommandRecord{});  // waiting records are kept
  log.reserve(500000);
  EXPECT_EQ(raven2_trainer::testing::allocatorCalls([&] {
              for (int i = 0; i < 200; ++i)
                log.write(TickRecord{});
            }),
            0);
  EXPECT_GT(raven2_trainer::testing::allocatorCalls([&] {
              for (int i = 0; i < 200; ++i)
                log.write(TickRecord{});
            }),
            0)
      << "or the batch was smaller than it says";
  ASSERT_TRUE(log.commit());
  EXPECT_EQ(readLog(path, {}).records, 401U);
}
#endif

TEST(SessionLog, GivesBackEveryRecordBitForBit) {
  const std::string path = scratchPath("round_trip.rlog");
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Contents expected = writeRandomLog(path, seed, 200);
    Contents got;
    const LogSummary summary = readLog(path, got.visitor());
    EXPECT_EQ(got.values, expected.values) << "seed " << seed;
    EXPECT_EQ(summary.records, 201u);
    EXPECT_TRUE(summary.clean);
    EXPECT_EQ(summary.bad_bytes, 0u);
    EXPECT_EQ(summary.truncated_bytes, 0u);
  }
}

TEST(SessionLog, GivesBackRecordsThatStraddleItsReadingWindow) {
  // GIVEN a log of more than thirty windows of 256 KiB
  const std::string path = scratchPath("long.rlog");
  const Contents expected = writeRandomLog(path, 99, 13000);
  ASSERT_GT(readBytes(path).size(), 9u * 1024 * 1024);
  Contents got;
  readLog(path, got.visitor());
  EXPECT_EQ(got.values, expected.values);
}

TEST(SessionLog, GivesBackItsHeader) {
  const std::string path = scratchPath("header.rlog");
  LogHeader header;
  header.seed = 0xFFFFFFFFFFFFFFFFULL;
  header.scenarios = {"sudden_jump", "a \"quoted\" name"};
  header.hazard = "sudden_jump";
  header.robot_urdf_hash = "0123456789abcdef";
  header.scene_urdf_hash = "fedcba9876543210";
  header.config_hash = "00000000deadbeef";
  header.motion = "recording:teleop.csv";
  header.d4 = -0.47;
  header.tolerance = 0.1 + 0.2;  // not a short decimal
  header.model_version = 7;
  header.arm_contacts = {true, false};
  header.body_names = {"link1_L", "ring"};
  header.exercise = "peg_transfer";
  header.drill = "sudden_jump";
  header.trainee = "t-01_x";
  header.curriculum = "frs_basics";
  header.motion_scale = 0.1 + 0.2;
  header.hand = {0.3, 100.0 / 3.0, 7.0};
  header.camera = {"endoscope", 0.7, 16.0 / 9.0};
  header.step_names = {{"lift", "place"}, {}, {"press"}};
  header.object_names = {"ring_left", "ring_right"};
  header.configuration = {{"configuration/a.yaml", "0011"}, {"configuration/b.yaml", "2233"}};
  LogWriter(path, header).finish({});
  for (const LogHeader& got : {readLog(path, {}).header, readLogHeader(path)}) {
    EXPECT_EQ(got.seed, header.seed);
    EXPECT_EQ(got.scenarios, header.scenarios);
    EXPECT_EQ(got.hazard, header.hazard);
    EXPECT_EQ(got.robot_urdf_hash, header.robot_urdf_hash);
    EXPECT_EQ(got.scene_urdf_hash, header.scene_urdf_hash);
    EXPECT_EQ(got.config_hash, header.config_hash);
    EXPECT_EQ(got.motion, header.motion);
    EXPECT_EQ(got.d4, header.d4);
    EXPECT_EQ(got.tolerance, header.tolerance);
    EXPECT_EQ(got.model_version, header.model_version);
    EXPECT_EQ(got.arm_contacts, header.arm_contacts);
    EXPECT_EQ(got.body_names, header.body_names);
    EXPECT_EQ(got.exercise, header.exercise);
    EXPECT_EQ(got.drill, header.drill);
    EXPECT_EQ(got.trainee, header.trainee);
    EXPECT_EQ(got.curriculum, header.curriculum);
    EXPECT_EQ(got.motion_scale, header.motion_scale);
    EXPECT_EQ(got.hand.mass, header.hand.mass);
    EXPECT_EQ(got.hand.stiffness, header.hand.stiffness);
    EXPECT_EQ(got.hand.damping, header.hand.damping);
    EXPECT_EQ(got.camera.name, header.camera.name);
    EXPECT_EQ(got.camera.vertical_fov, header.camera.vertical_fov);
    EXPECT_EQ(got.camera.aspect, header.camera.aspect);
    EXPECT_EQ(got.step_names, header.step_names);
    EXPECT_EQ(got.object_names, header.object_names);
    ASSERT_EQ(got.configuration.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(got.configuration[i].path, header.configuration[i].path);
      EXPECT_EQ(got.configuration[i].fnv1a, header.configuration[i].fnv1a);
    }
  }
}

TEST(SessionLog, GivesBackAHeaderLongerThanItsReadingWindow) {
  LogHeader header;
  for (int i = 0; i < 20000; ++i)
    header.scenarios.push_back("scenario_number_" + std::to_string(i));
  const std::string path = scratchPath("long_header.rlog");
  LogWriter(path, header).finish({});
  const LogSummary summary = readLog(path, {});
  EXPECT_EQ(summary.header.scenarios, header.scenarios);
  EXPECT_TRUE(summary.clean);
}

TEST(SessionLog, RefusesAHeaderThatNoReaderTakes) {
  LogHeader header;
  header.motion = std::string(2 * 1024 * 1024, 'x');
  EXPECT_THROW(LogWriter(scratchPath("huge_header.rlog"), header), SessionException);
}

TEST(SessionLog, TakesAFileNameThatIsNotUtf8) {
  const std::string path = scratchPath("latin1.rlog");
  LogHeader header;
  header.motion = "recording:\xE9tude.csv";
  LogWriter(path, header).finish({});
  EXPECT_EQ(readLogHeader(path).motion, "recording:\xEF\xBF\xBDtude.csv");
}

TEST(SessionLog, GivesTheSameBytesForTheSameRecords) {
  writeRandomLog(scratchPath("a.rlog"), 7, 300);
  writeRandomLog(scratchPath("b.rlog"), 7, 300);
  writeRandomLog(scratchPath("c.rlog"), 8, 300);
  EXPECT_EQ(readBytes(scratchPath("a.rlog")), readBytes(scratchPath("b.rlog")));
  EXPECT_NE(readBytes(scratchPath("a.rlog")), readBytes(scratchPath("c.rlog")));
}

TEST(SessionLog, KeepsPaddingOutOfItsBytes) {
  // GIVEN the same values in memory that was all zeros and in memory that was all ones
  std::array<Bytes, 2> bytes;
  std::array<TickRecord, 2> records;
  for (const int i : {0, 1}) {
    std::memset(static_cast<void*>(&records[i]), i == 0 ? 0x00 : 0xFF, sizeof(TickRecord));
    Random random(3);
    RandomFiller filler(random);
    visitFields(filler, records[i]);
    LogWriter log(scratchPath("padding.rlog"), LogHeader{});
    log.write(records[i]);
    log.finish({});
    bytes[i] = readBytes(scratchPath("padding.rlog"));
  }
  ASSERT_NE(std::memcmp(&records[0], &records[1], sizeof(TickRecord)), 0) << "no padding left in this record";
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST(SessionLog, IsUncleanWithoutItsLastRecord) {
  const std::string path = scratchPath("unclean.rlog");
  {
    LogWriter log(path, LogHeader{});
    log.write(TickRecord{});
  }
  const LogSummary summary = readLog(path, {});
  EXPECT_EQ(summary.records, 1u);
  EXPECT_FALSE(summary.clean);
}

TEST(SessionLog, RefusesRecordsAfterItsLast) {
  LogWriter log(scratchPath("finished.rlog"), LogHeader{});
  log.finish({});
  EXPECT_THROW(log.write(TickRecord{}), SessionException);
  EXPECT_THROW(log.finish({}), SessionException);
}

TEST(SessionLog, RefusesAFileThatCannotBeCreated) {
  EXPECT_THROW(LogWriter(scratchPath("no_such_folder") + "/session.rlog", LogHeader{}), SessionException);
}

TEST(SessionLog, OfALivingWriterIsNotReplacedByAnother) {
  const std::string path = scratchPath("two_writers.rlog");
  LogHeader header;
  header.seed = 1;
  LogWriter log(path, header);
  header.seed = 2;
  EXPECT_THROW(LogWriter(path, header), SessionException);
  log.write(TickRecord{});
  log.finish({});
  const LogSummary summary = readLog(path, {});
  EXPECT_EQ(summary.header.seed, 1U);
  EXPECT_EQ(summary.records, 2U);
  EXPECT_FALSE(std::filesystem::exists(path + ".new")) << "nothing of the other one is left";
}

TEST(SessionLog, SaysSoWhenTheDiskIsFull) {
  // /dev/full takes nothing; the writer's buffer may hide it for a while, but not past the end
  const auto write_log = [] { LogWriter("/dev/full", LogHeader{}).finish({}); };
  EXPECT_THROW(write_log(), SessionException);
}

}  // namespace
}  // namespace raven2_trainer::session
