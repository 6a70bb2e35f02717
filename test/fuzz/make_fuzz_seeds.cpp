#include <zstd.h>

#include <cstdio>
#include <functional>
#include <limits>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/wire/itp.h"
#include "raven2_trainer/wire/pedals.h"
#include "raven2_trainer/wire/robot_frame.h"
#include "raven2_trainer/wire/sight.h"
#include "session/formula.h"
#include "session/record_chunk.h"
#include "session/record_codec.h"
#include "session/record_frame.h"

// Writes the binary seeds of seeds/ from the real encoders, in the input formats that the targets describe.

namespace raven2_trainer::fuzz {
namespace {

void save(const std::string& target, const std::string& name, const Bytes& bytes) {
  const std::string folder = sourceFile("test/fuzz/seeds/" + target);
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/" + name, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

template <typename Container>
void append(const Container& from, Bytes* to) {
  to->insert(to->end(), from.begin(), from.end());
}

wire::ItpPacket packet(std::uint32_t sequence, bool pedal) {
  MasterCommand command;
  command.sequence = sequence;
  command.pedal = pedal ? 1 : 0;
  command.dp_I = {{{20e-6, -30e-6, 10e-6}, {-5e-6, 0.0, 7e-6}}};
  command.dq_I[0] = {0.001, 0.0, -0.001, 0.999999};
  command.dgrasp = {0.002, -0.001};
  return wire::fromCommand(command);
}

/** Datagrams with these sequence numbers; negative: the pedal is up. */
Bytes stream(const std::vector<std::int64_t>& sequences) {
  Bytes bytes;
  for (const std::int64_t s : sequences) {
    bytes.push_back(0);
    append(wire::encodeItp(packet(static_cast<std::uint32_t>(s < 0 ? -s : s), s >= 0)), &bytes);
  }
  return bytes;
}

Bytes oddValues() {
  Bytes bytes;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double x : {nan, std::numeric_limits<double>::infinity(), 5e-324, 1e200, 0.0}) {
    wire::ItpPacket p = packet(1, true);
    p.Qx[1] = p.Qy[1] = p.Qz[1] = p.Qw[1] = x;
    p.delx_um[0] = std::numeric_limits<std::int32_t>::min();
    bytes.push_back(0);
    append(wire::encodeItp(p), &bytes);
  }
  return bytes;
}

void itpSeeds() {
  Bytes rebase = stream({-7});
  for (int i = 0; i < 11; ++i)
    append(stream({-(1000 + i)}), &rebase);
  Bytes sizes = stream({1});
  append(Bytes{7, 1, 2, 3, 1, 0xFF}, &sizes);
  const std::vector<std::pair<const char*, Bytes>> streams{
      {"moves", stream({1, 2, 3, 4, 5})},
      {"gap_late_twice_jump", stream({10, 12, 11, 12, 90, 200, 13})},
      {"wrap", stream({4294967294, 4294967295, 0, 1})},
      {"pedal", stream({-1, -2, 3, 4, -5, 6})},
      {"rebase", rebase},
      {"odd_values", oddValues()},
      {"wrong_sizes", sizes}};
  const Bytes fault{0, 3, 1, 1, 2, 3, 5, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F};
  for (const auto& [name, bytes] : streams) {
    save("itp", name, bytes);
    save("teleop", name, bytes);
    Bytes with_fault = fault;
    append(bytes, &with_fault);
    save("raven_itp", name, with_fault);
  }
}

void forceSeeds() {
  ForcePacket force;
  force.sequence = 5;
  force.last_sequence = 4;
  force.runlevel = 3;
  force.force_I = {{{1.0, -2.0, 3.3}, {0.0, 0.05, -0.001}}};
  Bytes bytes{1};
  append(wire::encodeForce(force), &bytes);
  save("force", "packet", bytes);
  bytes.resize(40);
  save("force", "short", bytes);
}

void pedalSeeds() {
  Bytes bytes{0};
  append(wire::encodePedals({5, bit(Pedal::kCamera) | bit(Pedal::kStop)}), &bytes);
  save("pedals", "packet", bytes);
  bytes[0] = 1;
  bytes[1 + 12] = 0x7F;
  save("pedals", "all_held", bytes);
  bytes.resize(20);
  save("pedals", "short", bytes);
}

void sightSeeds() {
  Sight sight;
  sight.sequence = 5;
  sight.tick = 1234;
  sight.mode = Mode::kTeleoperating;
  sight.runlevel = RunLevel::kPedalDown;
  sight.tool_W[0] = {{0.01, -0.02, 0.03}, {0.0, 0.6, 0.0, 0.8}};
  sight.step = 2;
  Bytes bytes{0};
  append(wire::encodeSight(sight), &bytes);
  save("sight", "packet", bytes);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  bytes[0] = 1;
  std::memcpy(bytes.data() + 1 + 32, &nan, sizeof(nan));
  save("sight", "not_finite", bytes);
}

Bytes frame(const std::function<std::size_t(std::uint8_t*)>& encode) {
  Bytes bytes(wire::kMaxFrame);
  bytes.resize(encode(bytes.data()));
  return bytes;
}

FaultPlan plan() {
  FaultPlan p;
  p.generation = 3;
  p.count = 2;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    Fault& f = p.faults[i];
    f.id = i + 1;
    f.site = FaultSite::kPutUsbPacket;
    f.kind = FaultKind::kStuckAt;
    f.variable = FaultVariable::kDac;
    f.first_tick = i == 0 ? 2 : std::numeric_limits<std::int64_t>::max();
    f.duration_ticks = 3;
    f.period_ticks = 5;
    f.count = 2;
    f.value = 800.0;
  }
  return p;
}

void frameSeeds() {
  const Bytes hello = frame([](std::uint8_t* out) { return wire::encodeHello(1, true, out); });
  const Bytes state = frame([](std::uint8_t* out) { return wire::encodeState(2, RobotState{}, out); });
  const Bytes faults = frame([](std::uint8_t* out) { return wire::encodeFaultPlan(3, plan(), out); });
  Bytes all{0, 0};
  for (const Bytes* one : {&hello, &state, &faults, &state})
    append(*one, &all);
  save("frames", "link_byte_by_byte", all);
  for (const auto& [name, one] : {std::pair<const char*, const Bytes*>{"state", &state}, {"faults", &faults}}) {
    Bytes mended{1, 9};
    append(*one, &mended);
    save("frames", name, mended);
  }
  Bytes other{0, 5};
  append(hello, &other);
  other[2 + 5] = wire::kFrameMajor + 1;
  save("frames", "other_version", other);
}

template <typename T>
void appendRecord(const T& record, Bytes* bytes) {
  Bytes payload(session::kMaxPayload);
  ByteWriter out(payload.data(), payload.size());
  session::FieldWriter fields(out);
  session::visitFields(fields, record);
  payload.resize(out.size());
  append(Bytes{static_cast<std::uint8_t>(session::RecordTypeOf<T>::kType), 0, static_cast<std::uint8_t>(out.size()),
               static_cast<std::uint8_t>(out.size() >> 8U)},
         bytes);
  append(payload, bytes);
}

/** The contents of a chunk with six requests and six exercise events. */
Bytes chunkSeed() {
  Bytes frames, chunk;
  for (std::uint8_t i = 0; i < 12; ++i) {
    Bytes record;
    i % 2 == 0 ? appendRecord(RequestRecord{i, {}}, &record) : appendRecord(ExerciseRecord{i, {}}, &record);
    const std::size_t length = record.size() - 4;
    Bytes frame(session::kFrameHeaderSize);
    session::encodeFrameHeader({session::kMagic, static_cast<session::RecordType>(record[0]), session::kRecordVersion,
                                static_cast<std::uint32_t>(length), i},
                               frame.data());
    frame.insert(frame.end(), record.begin() + 4, record.end());
    frame.resize(frame.size() + session::kCrcSize);
    append(frame, &frames);
  }
  session::ChunkPacker(std::nullopt).pack(frames.data(), frames.size(), &chunk);
  const std::uint8_t* payload = chunk.data() + session::kFrameHeaderSize + session::kChunkSpanSize;
  const std::size_t length = session::decodeFrameHeader(chunk.data()).length - session::kChunkSpanSize;
  Bytes contents(ZSTD_getFrameContentSize(payload, length));
  ZSTD_decompress(contents.data(), contents.size(), payload, length);
  Bytes seed{1, 0, 4, static_cast<std::uint8_t>(contents.size()), static_cast<std::uint8_t>(contents.size() >> 8U)};
  append(contents, &seed);
  return seed;
}

/** Three records of a robot's cycle and six blocks of joints, with a formula of each kind. */
Bytes formulaSeed() {
  constexpr std::uint32_t kRows = 3, kColumns = 43;
  const std::array<std::uint32_t, 5> head{kRows, 1, 1U | session::kRecordVersion << 16U, kRows, kColumns};
  const auto* begin = reinterpret_cast<const std::uint8_t*>(head.data());
  Bytes contents(begin, begin + sizeof(head));
  contents.insert(contents.end(), kRows, 0);  // all of group 0
  contents.push_back(8);                      // forms
  contents.insert(contents.end(), kColumns - 1, 0x88);
  contents.insert(contents.end(), 15, 0);  // orders: cycle, motors of gold and green
  contents.insert(contents.end(), kColumns - 15, 0x80);
  using session::FormulaKind;
  const std::vector<session::Formula> formulas{
      {FormulaKind::kRobot, {0, 1, 8, 15, 22, 15, 22}, std::vector<double>(182, 0.1)},
      {FormulaKind::kTip, {15, 1, 29, 32}, {0.0, -0.47, 0.013}},
      {FormulaKind::kOrientation, {22, 35}, {1.0, -0.47, 0.013}},
      {FormulaKind::kPositions, {15, 36}, std::vector<double>(14, 0.2)},
      {FormulaKind::kControl, {1, 8, 36, 36}, std::vector<double>(28, 3.0)}};
  contents.push_back(static_cast<std::uint8_t>(formulas.size()));
  for (const session::Formula& formula : formulas)
    formula.append(&contents);
  for (std::uint32_t i = 0; i < 8 * kRows * kColumns; ++i)
    contents.push_back(static_cast<std::uint8_t>(i % 7));
  Bytes seed{1, 0, 4, static_cast<std::uint8_t>(contents.size()), static_cast<std::uint8_t>(contents.size() >> 8U)};
  append(contents, &seed);
  return seed;
}

void logSeeds() {
  Bytes small{1}, plan{1};
  appendRecord(TickRecord{}, &small);
  appendRecord(HapticRecord{}, &small);
  appendRecord(CommandRecord{}, &small);
  appendRecord(RequestRecord{}, &small);
  appendRecord(ContactRecord{}, &small);
  appendRecord(ExecutionRecord{}, &small);
  appendRecord(ExerciseRecord{}, &small);
  appendRecord(SessionCounts{}, &small);
  save("session_log", "records", small);
  appendRecord(PlanRecord{}, &plan);
  save("session_log", "plan", plan);
  save("session_log", "chunk", chunkSeed());
  save("session_log", "formulas", formulaSeed());
  save("session_log", "no_log", Bytes{0, 'R', 'V', '2', 'L', 0, 0, 5, 0, 0xFF, 0xFF, 0xFF, 0xFF});
}

}  // namespace
}  // namespace raven2_trainer::fuzz

int main() {
  raven2_trainer::fuzz::itpSeeds();
  raven2_trainer::fuzz::forceSeeds();
  raven2_trainer::fuzz::pedalSeeds();
  raven2_trainer::fuzz::sightSeeds();
  raven2_trainer::fuzz::frameSeeds();
  raven2_trainer::fuzz::logSeeds();
  std::puts("seeds written");
  return 0;
}
