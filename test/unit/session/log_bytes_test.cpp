#include <map>
#include <string>

#include "log_file.h"
#include "raven2_trainer/session/session_log.h"
#include "record_values.h"
#include "session/header_json.h"

// The format as doc/session.md states it, encoded here by hand and without the writer's own helpers.

namespace raven2_trainer::session {
namespace {

/** Little-endian, byte by byte. */
void append(Bytes* bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i)
    bytes->push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/** CRC-32 of IEEE 802.3, bit by bit: reflected polynomial 0xEDB88320, start and end inverted. */
std::uint32_t slowCrc32(const Bytes& bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

/** Bytes of a log behind its first record. */
Bytes bytesBehindHeader(const std::string& path) {
  const Bytes file = readBytes(path);
  const std::uint32_t length =
      file[8] | (file[9] << 8U) | (file[10] << 16U) | (static_cast<std::uint32_t>(file[11]) << 24U);
  return Bytes(file.begin() + 20 + length + 4, file.end());
}

TEST(SessionLogBytes, AreThoseOfARequestWrittenByHand) {
  RequestRecord record;
  record.tick = 4660;
  record.request.kind = RequestKind::kPlan;
  record.request.arm = Arm::kGreen;
  record.request.choose_arm = 1;
  record.request.goal = GoalKind::kJoints;
  record.request.enabled = 1;
  record.request.goal_W = {1.0, -2.0, 0.5};
  record.request.goal_q[6] = -2.0;
  record.request.id = 0xA1B2C3D4U;
  record.request.on_robot = 1;
  record.request.plan = 0x0BADF00DU;
  const std::string path = scratchPath("golden.rlog");
  {
    LogWriter log(path, LogHeader{});
    log.write(record);
  }
  Bytes expected{'R', 'V', '2', 'L'};
  append(&expected, 4, 2);                      // type: request
  append(&expected, 10, 2);                      // version
  append(&expected, 8 + 6 + 24 + 56 + 8, 4);    // payload length
  append(&expected, 1, 8);                      // record number: the header is 0
  append(&expected, 0x1234, 8);                 // tick
  append(&expected, 3, 1);                      // kPlan
  append(&expected, 1, 1);                      // green
  append(&expected, 1, 1);                      // choose_arm
  append(&expected, 2, 1);                      // joints
  append(&expected, 1, 1);                      // enabled
  append(&expected, 1, 1);                      // on_robot
  append(&expected, 0x3FF0000000000000ULL, 8);  // 1.0 in IEEE 754
  append(&expected, 0xC000000000000000ULL, 8);  // -2.0
  append(&expected, 0x3FE0000000000000ULL, 8);  // 0.5
  for (int j = 0; j < 6; ++j)
    append(&expected, 0, 8);
  append(&expected, 0xC000000000000000ULL, 8);  // -2.0 of the last joint
  append(&expected, 0xA1B2C3D4ULL, 4);          // id
  append(&expected, 0x0BADF00DULL, 4);          // plan
  append(&expected, slowCrc32(expected), 4);
  EXPECT_EQ(bytesBehindHeader(path), expected);
}

TEST(SessionLogBytes, AreThoseOfAnExercisesEventWrittenByHand) {
  ExerciseRecord record;
  record.tick = 0x102030405;
  record.event.kind = ExerciseEventKind::kTouchEnded;
  record.event.mistake = Mistake::kCollision;
  record.event.arm = Hand::kGreen;
  record.event.track = 2;
  record.event.step = kNobody;
  record.event.a = 0x0102;
  record.event.value = -2.0;
  record.event.force = 0.5;
  const std::string path = scratchPath("golden_event.rlog");
  {
    LogWriter log(path, LogHeader{});
    log.write(record);
  }
  Bytes expected{'R', 'V', '2', 'L'};
  append(&expected, 13, 2);                     // type: exercise
  append(&expected, 10, 2);                      // version
  append(&expected, 8 + 5 + 4 + 16, 4);         // payload length
  append(&expected, 1, 8);                      // record number
  append(&expected, 0x102030405ULL, 8);         // tick
  append(&expected, 7, 1);                      // touch_ended
  append(&expected, 1, 1);                      // collision
  append(&expected, 1, 1);                      // green
  append(&expected, 2, 1);                      // track
  append(&expected, 255, 1);                    // no step
  append(&expected, 0x0102, 2);                 // a
  append(&expected, 0xFFFF, 2);                 // b: none
  append(&expected, 0xC000000000000000ULL, 8);  // -2.0
  append(&expected, 0x3FE0000000000000ULL, 8);  // 0.5
  append(&expected, slowCrc32(expected), 4);
  EXPECT_EQ(bytesBehindHeader(path), expected);
}

TEST(SessionLogBytes, StartWithTheHeaderRecord) {
  const std::string path = scratchPath("start.rlog");
  LogHeader header;
  header.seed = 42;
  { LogWriter log(path, header); }
  const Bytes file = readBytes(path);
  const std::string json = headerToJson(header);
  Bytes expected{'R', 'V', '2', 'L', 0, 0, 10, 0};
  append(&expected, json.size(), 4);
  append(&expected, 0, 8);
  expected.insert(expected.end(), json.begin(), json.end());
  append(&expected, slowCrc32(expected), 4);
  EXPECT_EQ(file, expected);
}

/** [bytes] that the schema's fields announce. */
std::size_t schemaSize(const nlohmann::json& fields) {
  const std::map<std::string, std::size_t> sizes{{"u8", 1},  {"i8", 1},  {"u16", 2}, {"i16", 2}, {"u32", 4},
                                                 {"i32", 4}, {"f32", 4}, {"u64", 8}, {"i64", 8}, {"f64", 8}};
  std::size_t total = 0;
  for (const auto& field : fields) {
    const std::string type = field.at("type");
    std::size_t size = type == "struct" ? schemaSize(field.at("fields")) : sizes.at(type);
    for (const std::size_t count : field.at("shape"))
      size *= count;
    total += size;
  }
  return total;
}

template <typename T>
std::size_t payloadSize() {
  std::array<std::uint8_t, 16384> bytes{};
  ByteWriter out(bytes.data(), bytes.size());
  FieldWriter fields(out);
  const T record{};
  visitFields(fields, record);
  return out.size();
}

TEST(SessionLogSchema, AnnouncesAsManyBytesAsAreWritten) {
  const auto json = nlohmann::json::parse(headerToJson(LogHeader{}));
  const std::map<std::string, std::size_t> written{{"tick", payloadSize<TickRecord>()},
                                                   {"haptic", payloadSize<HapticRecord>()},
                                                   {"command", payloadSize<CommandRecord>()},
                                                   {"request", payloadSize<RequestRecord>()},
                                                   {"plan", payloadSize<PlanRecord>()},
                                                   {"contact", payloadSize<ContactRecord>()},
                                                   {"faults", payloadSize<FaultRecord>()},
                                                   {"counts", payloadSize<SessionCounts>()},
                                                   {"gap", payloadSize<GapRecord>()},
                                                   {"recovery", payloadSize<RecoveryRecord>()},
                                                   {"fault_change", payloadSize<FaultChangeRecord>()},
                                                   {"execution", payloadSize<ExecutionRecord>()},
                                                   {"exercise", payloadSize<ExerciseRecord>()}};
  ASSERT_EQ(json.at("records").size(), written.size());
  for (const auto& record : json.at("records")) {
    EXPECT_EQ(schemaSize(record.at("fields")), written.at(record.at("name"))) << record.at("name");
  }
}

TEST(SessionLogSchema, NamesUnitsAndMeanings) {
  const auto json = nlohmann::json::parse(headerToJson(LogHeader{}));
  const auto& model = json.at("records").at(0).at("fields").at(0);
  EXPECT_EQ(model.at("name"), "model");
  EXPECT_EQ(model.at("type"), "struct");
  EXPECT_EQ(model.at("fields").at(0), (nlohmann::json{{"name", "tick"},
                                                      {"type", "i64"},
                                                      {"shape", nlohmann::json::array()},
                                                      {"unit", "ms"},
                                                      {"meaning", "physics step that produced this state"}}));
  EXPECT_EQ(model.at("fields").at(3).at("names").at(2), "teleoperating");
  const auto& arms = model.at("fields").at(18);
  EXPECT_EQ(arms.at("shape"), nlohmann::json::array({2}));
  EXPECT_EQ(arms.at("fields").at(0).at("shape"), nlohmann::json::array({7}));
}

TEST(SessionLogSchema, NamesWhatNumbersOfTheExerciseMean) {
  const auto json = nlohmann::json::parse(headerToJson(LogHeader{}));
  EXPECT_EQ(json.at("mistake_names").at(2), "drop");
  EXPECT_EQ(json.at("pedal_names").at(4), "camera");
  const auto& exercise = json.at("records").at(0).at("fields").at(0).at("fields").at(12);
  EXPECT_EQ(exercise.at("name"), "exercise");
  EXPECT_EQ(exercise.at("fields").at(0).at("names").at(3), "done");
  EXPECT_EQ(exercise.at("fields").at(7).at("shape"), nlohmann::json::array({12}));
}

TEST(SessionLogSchema, KnowsEveryMemberOfTheRecords) {
  // A member that is added to a struct and not to log_layout.h would be lost silently. Sums of the members' sizes
  // plus the padding between them, by hand; a change here asks for a change there and a new kRecordVersion.
  EXPECT_EQ(sizeof(ArmState), 28 * 8 + 3 * 8 + 3 * 8 + 4 * 8 + 4 + 4u);
  EXPECT_EQ(sizeof(FaultSignals), 2 * 8 + 2 * 4u);
  EXPECT_EQ(sizeof(DaemonFaults), 4 + 4 + 4 + /*padding*/ 4 + 2 * 8 + 6 * 8 + sizeof(FaultSignals));
  EXPECT_EQ(sizeof(ModelState), 3 * 8 + 5 + /*padding*/ 3 + 2 * 4 + 6 * 8 + sizeof(PlanningState) +
                                    sizeof(ExerciseState) + sizeof(CameraState) + 2 * 4 + 1 + /*padding*/ 7 +
                                    sizeof(DaemonFaults) + 2 * sizeof(ArmState) + 12 * 7 * 8u);
  EXPECT_EQ(sizeof(ExerciseState), 3 + /*padding*/ 1 + 4 + 8 + 2 * 8 + 12 + 6 * 4 + /*padding*/ 4 + 8u);
  EXPECT_EQ(sizeof(CameraState), 9 * 8u);
  EXPECT_EQ(sizeof(PlanningState), 4 + 2 * 4 + /*padding*/ 4 + 8u);
  EXPECT_EQ(sizeof(RobotArmState), 21 * 8 + 7 * 4 + 7 + /*padding*/ 5 + 6 * 8u);
  EXPECT_EQ(sizeof(LinkCounts), (2 + kRejectCount) * 8u);
  EXPECT_EQ(sizeof(RobotState), 4 * 8 + 2 * 4 + 7 + /*program*/ 1 + 2 * sizeof(RobotArmState) + sizeof(LinkCounts));
  EXPECT_EQ(sizeof(HapticState), 4 * 8 + 7 * 6 * 8 + 5 * 2 * 8 + 4 + 2 + /*padding*/ 2u);
  EXPECT_EQ(sizeof(MasterCommand), 4 + 1 + /*padding*/ 3 + 2 * (3 + 4 + 1) * 8u);
  EXPECT_EQ(sizeof(Request), 6 + /*padding*/ 2 + 3 * 8 + 7 * 8 + 2 * 4u);
  EXPECT_EQ(sizeof(PlanResult),
            4 + 2 + /*padding*/ 2 + 4 + /*padding*/ 4 + 64 * 8 * 8 + 4 * 8 + 4 + 1 + /*padding*/ 3u);
  EXPECT_EQ(sizeof(ExecutionReport), 2 * 4 + 3 + /*padding*/ 5 + 2 * 8 + 3 * 8 + 2 * 3 * 8 + 2 * 8 + 2 * 4u);
  EXPECT_EQ(sizeof(Histogram), Histogram::kBuckets * 4u);
  EXPECT_EQ(sizeof(LoopTiming), 13 * 8 + 2 * sizeof(Histogram));
  EXPECT_EQ(sizeof(RingCounts), 3 * 8u);
  EXPECT_EQ(sizeof(SessionCounts), 3 * sizeof(LinkCounts) + 15 * 8 + 3 * 3 * 8 + 2 * sizeof(LoopTiming) +
                                       kRingCount * sizeof(RingCounts) + 2 + /*padding*/ 6u);
  EXPECT_EQ(sizeof(Fault), 4 + 8 + 4 + 12 * 8u);
  EXPECT_EQ(sizeof(FaultPlan), 8 + 4 + 4 + 1 + /*padding*/ 7 + 8 * sizeof(Fault));
  EXPECT_EQ(payloadSize<FaultRecord>(), 8 + /*generation, count*/ 8 + 4 + 8 * sizeof(Fault));
  EXPECT_EQ(sizeof(FaultChange), 2 * 8 + 2 * 4 + 3 + /*padding*/ 5u);
  EXPECT_EQ(payloadSize<FaultChangeRecord>(), 8 + sizeof(FaultChange) - 5 - /*session*/ 4);
  EXPECT_EQ(payloadSize<TickRecord>(), sizeof(ModelState) - 3 - 4 - 4 - 5 - 7 + sizeof(RobotState) - 1 - 2 * 5 + 1);
  EXPECT_EQ(payloadSize<TickRecord>(), 2391u) << "as doc/session.md says";
  EXPECT_EQ(payloadSize<HapticRecord>(), sizeof(HapticState) - 2);
  EXPECT_EQ(payloadSize<CommandRecord>(), 8 + sizeof(MasterCommand) - 3);
  EXPECT_EQ(payloadSize<RequestRecord>(), 8 + sizeof(Request) - 2);
  EXPECT_EQ(sizeof(ContactRecord), 8 + 2 * 2 + 4 + 7 * 8u);
  EXPECT_EQ(payloadSize<ContactRecord>(), sizeof(ContactRecord));
  EXPECT_EQ(payloadSize<PlanRecord>(), 8 + sizeof(PlanResult) - 9 + 1);
  EXPECT_EQ(payloadSize<ExecutionRecord>(), 8 + sizeof(ExecutionReport) - 5);
  EXPECT_EQ(sizeof(ExerciseEvent), 5 + /*padding*/ 1 + 2 * 2 + /*padding*/ 6 + 2 * 8u);
  EXPECT_EQ(payloadSize<ExerciseRecord>(), 8 + sizeof(ExerciseEvent) - 7);
  EXPECT_EQ(sizeof(GapRecord), 8 + 1 + /*padding*/ 3 + 4 + 10 * 8u);
  EXPECT_EQ(payloadSize<GapRecord>(), sizeof(GapRecord) - 3);
  EXPECT_EQ(sizeof(RecoveryRecord), 11 * 8u);
  EXPECT_EQ(payloadSize<RecoveryRecord>(), 11 * 8u);
  EXPECT_EQ(payloadSize<SessionCounts>(), sizeof(SessionCounts) - 6);
}

}  // namespace
}  // namespace raven2_trainer::session
