#include <zstd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "log_file.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/session/session_log.h"
#include "record_values.h"
#include "session/column_code.h"
#include "session/record_chunk.h"
#include "session/record_columns.h"
#include "support/effort.h"

namespace raven2_trainer::session {
namespace {

constexpr ColumnForm kDouble(8 | ColumnForm::kFloatBit);

/** The planes of one column, lowest first, and the order of its differences. */
struct Coded {
  std::uint8_t order;
  Bytes planes;
};

template <typename T>
Bytes bytesOf(const std::vector<T>& values) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(values.data());
  return Bytes(begin, begin + values.size() * sizeof(T));
}

template <typename T>
Coded encode(ColumnForm form, const std::vector<T>& values) {
  Coded coded{0, Bytes(values.size() * sizeof(T))};
  const Bytes bytes = bytesOf(values);
  const ColumnView column{form, bytes.data(), sizeof(T), values.size(), nullptr};
  ColumnCoder coder;
  const ColumnChoice choice = coder.choose(column);
  coder.encode(column, choice, coded.planes.data(), values.size());
  coded.order = choice.code;
  return coded;
}

template <typename T>
Bytes decode(ColumnForm form, const Coded& coded, std::size_t rows) {
  Bytes values(rows * sizeof(T));
  ColumnCoder().decode(form, coded.order, coded.planes.data(), rows, rows, values.data(), sizeof(T));
  return values;
}

template <typename T>
void expectTheSameBack(ColumnForm form, const std::vector<T>& values) {
  EXPECT_EQ(decode<T>(form, encode(form, values), values.size()), bytesOf(values));
}

TEST(Columns, AreKeptAsTheDifferencesThatAreSmallest) {
  // Steps of 10: their differences are 10, then 0. A difference d >= 0 is kept as 2 d, one below 0 as -2 d - 1.
  EXPECT_EQ(encode(ColumnForm(1), std::vector<std::uint8_t>{10, 20, 30, 40, 50}).planes, (Bytes{20, 0, 0, 0, 0}));
  EXPECT_EQ(encode(ColumnForm(1), std::vector<std::uint8_t>{10, 20, 30, 40, 50}).order, 2);
  EXPECT_EQ(encode(ColumnForm(1), std::vector<std::uint8_t>{100, 99, 100, 99, 99}).planes, (Bytes{200, 1, 2, 1, 0}));
  EXPECT_EQ(encode(ColumnForm(1), std::vector<std::uint8_t>{7, 7, 7}).planes, (Bytes{14, 0, 0}));
  EXPECT_EQ(encode(ColumnForm(1), std::vector<std::uint8_t>{0, 0, 0}).order, 0);
  const Coded rare = encode(ColumnForm(1), std::vector<std::uint8_t>{0, 0, 200, 0, 0});
  EXPECT_EQ(rare.order, 0) << "differences would say it twice";
  EXPECT_EQ(rare.planes, (Bytes{0, 0, 200, 0, 0}));
  // Two bytes: all lowest ones, then all highest ones. 0x0101 is itself.
  const Coded wide = encode(ColumnForm(2), std::vector<std::uint16_t>{0x0101, 0, 0});
  EXPECT_EQ(wide.order, 0);
  EXPECT_EQ(wide.planes, (Bytes{1, 0, 0, 1, 0, 0}));
}

TEST(Columns, TakeNeighboursOfADoubleForNeighbours) {
  std::vector<double> values{-0.0};
  for (int i = 0; i < 9; ++i)
    values.push_back(std::nextafter(values.back(), 1.0));  // from below zero to above
  const Coded coded = encode(kDouble, values);
  const Bytes lowest(coded.planes.begin(), coded.planes.begin() + 10);
  for (std::size_t i = 3; i < 10; ++i)
    EXPECT_LE(lowest[i], 2) << i;
  expectTheSameBack(kDouble, values);
}

template <typename T>
std::vector<T> randomColumn(Random* random, std::size_t rows) {
  std::vector<T> values(rows);
  std::uint64_t slope = 0, value = 0;
  const unsigned kept = random->next() % 64;
  for (T& v : values) {
    const std::uint64_t any = ((static_cast<std::uint64_t>(random->next()) << 32U) | random->next()) >> kept;
    slope += random->next() % 4 == 0 ? any : 0;
    value += slope;
    std::memcpy(&v, &value, sizeof(T));
  }
  return values;
}

TEST(Columns, GiveBackAnyNumbers) {
  Random random(23);
  for (int i = 0; i < 200; ++i) {
    const std::size_t rows = random.next() % 40;
    expectTheSameBack(ColumnForm(1), randomColumn<std::uint8_t>(&random, rows));
    expectTheSameBack(ColumnForm(2), randomColumn<std::uint16_t>(&random, rows));
    expectTheSameBack(ColumnForm(4), randomColumn<std::uint32_t>(&random, rows));
    expectTheSameBack(ColumnForm(8), randomColumn<std::uint64_t>(&random, rows));
    expectTheSameBack(kDouble, randomColumn<std::uint64_t>(&random, rows));  // every double, NaN and infinities, too
  }
  using Limits = std::numeric_limits<double>;
  expectTheSameBack(kDouble, std::vector<double>{0.0, -0.0, Limits::infinity(), -Limits::infinity(), Limits::max(),
                                                 Limits::lowest(), Limits::denorm_min(), -Limits::quiet_NaN()});
  using Whole = std::numeric_limits<std::int64_t>;
  expectTheSameBack(ColumnForm(8), std::vector<std::int64_t>{Whole::min(), Whole::max(), -1, 0, 1, Whole::min()});
}

TEST(Columns, HaveTheFormsOfTheRecordsNumbers) {
  const std::vector<std::uint8_t> request = columnForms(RecordType::kRequest, 8 + 6 + 24 + 56 + 8);
  std::vector<std::uint8_t> expected{8, 1, 1, 1, 1, 1, 1};  // tick, six bytes
  expected.insert(expected.end(), 10, 0x88);                // goal: three doubles and seven
  expected.insert(expected.end(), 2, 4);
  EXPECT_EQ(request, expected);
  EXPECT_EQ(columnForms(RecordType::kRequest, 3), (std::vector<std::uint8_t>{1, 1, 1})) << "of another version";
}

// ---- chunks -------------------------------------------------------------------------------------------------------

/** 300 requests, 300 more, the counters: two chunks between header and footer. The request's id says which it is. */
struct ChunkedLog {
  std::string path;
  Bytes bytes;
  std::vector<std::size_t> ends;  ///< of the header, each chunk and the footer
};

constexpr std::uint32_t kPerChunk = 300;

ChunkedLog makeChunkedLog() {
  ChunkedLog made{scratchPath("chunked.rlog"), {}, {}};
  LogWriter log(made.path, LogHeader{});
  for (std::uint32_t i = 0; i < 2 * kPerChunk; ++i) {
    RequestRecord record;
    record.tick = i;
    record.request.id = i;
    record.request.goal_W[0] = std::sin(0.01 * i);
    log.write(record);
    if (i + 1 == kPerChunk) {
      EXPECT_TRUE(log.commit());
    }
  }
  log.finish({});
  made.bytes = readBytes(made.path);
  for (std::size_t end = 0; end < made.bytes.size();) {
    end += kFrameHeaderSize + decodeFrameHeader(made.bytes.data() + end).length + kCrcSize;
    made.ends.push_back(end);
  }
  return made;
}

struct ReadBack {
  LogSummary summary;
  std::vector<std::uint32_t> ids;
};

ReadBack readBack(const Bytes& bytes) {
  const std::string path = scratchPath("chunks_damaged.rlog");
  writeBytes(path, bytes);
  ReadBack found;
  LogVisitor visitor;
  visitor.request = [&found](const RequestRecord& record) { found.ids.push_back(record.request.id); };
  found.summary = readLog(path, visitor);
  return found;
}

std::vector<std::uint32_t> idsOf(bool first, bool second) {
  std::vector<std::uint32_t> ids;
  for (std::uint32_t i = 0; i < 2 * kPerChunk; ++i) {
    if (i < kPerChunk ? first : second) ids.push_back(i);
  }
  return ids;
}

FrameHeader headerAt(const ChunkedLog& log, std::size_t record) {
  return decodeFrameHeader(log.bytes.data() + log.ends[record - 1]);
}

TEST(Chunks, HoldLargeBatchesAndLeaveTheLastRecordAsItIs) {
  const ChunkedLog log = makeChunkedLog();
  ASSERT_EQ(log.ends.size(), 4U);
  EXPECT_EQ(headerAt(log, 1).type, RecordType::kChunk);
  EXPECT_EQ(headerAt(log, 1).number, 1U) << "that of its first record";
  EXPECT_EQ(headerAt(log, 2).type, RecordType::kChunk);
  EXPECT_EQ(headerAt(log, 2).number, 1U + kPerChunk);
  EXPECT_EQ(headerAt(log, 3).type, RecordType::kCounts);
  EXPECT_EQ(headerAt(log, 3).number, 1U + 2 * kPerChunk);
  EXPECT_LT(log.ends[1] - log.ends[0], kPerChunk * 126 / 5) << "a fifth of the records alone";
  const ReadBack found = readBack(log.bytes);
  EXPECT_EQ(found.ids, idsOf(true, true));
  EXPECT_EQ(found.summary.records, 2 * kPerChunk + 1);
  EXPECT_TRUE(found.summary.clean);
  EXPECT_EQ(found.summary.bad_bytes + found.summary.truncated_bytes, 0U);
}

Bytes contentsOf(const ChunkedLog& log) {
  const std::uint8_t* compressed = log.bytes.data() + log.ends[0] + kFrameHeaderSize + kChunkSpanSize;
  const std::size_t size = headerAt(log, 1).length - kChunkSpanSize;
  Bytes contents(ZSTD_getFrameContentSize(compressed, size));
  EXPECT_EQ(ZSTD_decompress(contents.data(), contents.size(), compressed, size), contents.size());
  return contents;
}

/** The contents as doc/session.md states them, taken apart by hand. */
TEST(Chunks, HaveTheContentsThatTheirPageStates) {
  const ChunkedLog log = makeChunkedLog();
  const Bytes contents = contentsOf(log);
  std::array<Tick, 2> span{};
  std::memcpy(span.data(), log.bytes.data() + log.ends[0] + kFrameHeaderSize, 16);
  EXPECT_EQ(span, (std::array<Tick, 2>{0, kPerChunk - 1})) << "first and last tick, not compressed";
  const auto number = [&](std::size_t at, std::size_t size) {
    std::uint64_t value = 0;
    std::memcpy(&value, contents.data() + at, size);
    return value;
  };
  EXPECT_EQ(number(0, 4), kPerChunk);  // records
  EXPECT_EQ(number(4, 4), 1U);         // groups
  EXPECT_EQ(number(8, 2), 4U);         // type: request
  EXPECT_EQ(number(10, 2), 10U);       // version
  EXPECT_EQ(number(12, 4), kPerChunk);
  EXPECT_EQ(number(16, 4), 19U);  // numbers in a record
  const std::size_t forms = 20 + kPerChunk, orders = forms + 19, data = orders + 19 + 1;
  EXPECT_EQ(number(data - 1, 1), 0U);      // formulas
  EXPECT_EQ(number(forms, 1), 8U);         // tick
  EXPECT_EQ(number(forms + 7, 1), 0x88U);  // goal, a double
  EXPECT_EQ(contents.size(), data + kPerChunk * 102);
  // Ten doubles come first, then the tick: its lowest bytes, then the others. Then id and plan, 4 bytes each.
  EXPECT_EQ(number(orders, 1), 2U) << "a tick is a ramp: its second differences are 0, 1, 0, 0, ...";
  const std::size_t tick = data + 8 * 10 * kPerChunk, id = tick + 8 * kPerChunk;
  EXPECT_EQ(number(tick, 1), 0U);
  EXPECT_EQ(number(tick + 1, 1), 2U) << "1, folded";
  EXPECT_EQ(number(tick + 2, 1), 0U);
  EXPECT_EQ(number(id, 1), 0U) << "also a ramp, so it comes before the plan, whose order is 0";
  EXPECT_EQ(number(id + 1, 1), 2U);
  EXPECT_EQ(number(id + kPerChunk, 1), 0U);
}

void appendFrame(FrameHeader header, const std::uint8_t* payload, Bytes* bytes) {
  Bytes frame(kFrameHeaderSize);
  encodeFrameHeader(header, frame.data());
  frame.insert(frame.end(), payload, payload + header.length);
  const std::uint32_t crc = crc32Of(frame.data(), frame.size());
  const auto* tail = reinterpret_cast<const std::uint8_t*>(&crc);
  frame.insert(frame.end(), tail, tail + kCrcSize);
  bytes->insert(bytes->end(), frame.begin(), frame.end());
}

/** The same log in format 1: the header has version 1, and each record has its frame. */
Bytes inTheFirstFormat(const ChunkedLog& log) {
  const auto at = [&](std::size_t record) { return record == 0 ? 0 : log.ends[record - 1]; };
  Bytes bytes;
  for (std::size_t i = 0; i < log.ends.size(); ++i) {
    FrameHeader header = decodeFrameHeader(log.bytes.data() + at(i));
    const std::uint8_t* payload = log.bytes.data() + at(i) + kFrameHeaderSize;
    if (header.type == RecordType::kHeader) {
      std::string json(payload, payload + header.length);
      const std::string version = "\"format_version\":" + std::to_string(kFormatVersion);
      EXPECT_NE(json.find(version), std::string::npos);
      json.replace(json.find(version), version.size(), "\"format_version\":1");
      appendFrame(header, reinterpret_cast<const std::uint8_t*>(json.data()), &bytes);
      continue;
    }
    ChunkReader chunk;
    if (header.type != RecordType::kChunk) appendFrame(header, payload, &bytes);
    if (header.type != RecordType::kChunk || !chunk.open(header, payload)) continue;
    while (chunk.next(&header, &payload))
      appendFrame(header, payload, &bytes);
  }
  return bytes;
}

TEST(Chunks, ALogOfTheFirstFormatHasTheSameRecordsWithoutThem) {
  const Bytes bytes = inTheFirstFormat(makeChunkedLog());
  EXPECT_GT(bytes.size(), 2 * kPerChunk * 126);
  ReadBack found = readBack(bytes);
  EXPECT_EQ(found.ids, idsOf(true, true));
  EXPECT_EQ(found.summary.records, 2 * kPerChunk + 1);
  EXPECT_TRUE(found.summary.clean);
  EXPECT_EQ(found.summary.bad_bytes + found.summary.truncated_bytes, 0U);
}

TEST(Chunks, ALogThatIsCutEndsWithTheLastWholeOne) {
  const ChunkedLog log = makeChunkedLog();
  for (std::size_t cut = log.ends[0]; cut < log.bytes.size(); cut += 1 + cut % 5) {
    const ReadBack found = readBack(Bytes(log.bytes.begin(), log.bytes.begin() + static_cast<std::ptrdiff_t>(cut)));
    ASSERT_EQ(found.ids, idsOf(cut >= log.ends[1], cut >= log.ends[2])) << cut;
    ASSERT_EQ(found.summary.bad_bytes, 0U) << "a cut is no damage";
  }
}

TEST(Chunks, AFlippedBitCostsOneChunk) {
  const ChunkedLog log = makeChunkedLog();
  Random random(2017);
  for (std::int64_t i = 0; i < raven2_trainer::testing::effort(150, 1000); ++i) {
    const auto span = static_cast<std::uint32_t>(log.ends[2] - log.ends[0]);
    const std::size_t at = log.ends[0] + random.next() % span;
    Bytes bytes = log.bytes;
    bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1U << (random.next() % 8)));
    const bool is_first = at < log.ends[1];
    const ReadBack found = readBack(bytes);
    ASSERT_EQ(found.ids, idsOf(!is_first, is_first)) << at;
    ASSERT_EQ(found.summary.bad_bytes, is_first ? log.ends[1] - log.ends[0] : log.ends[2] - log.ends[1]);
    ASSERT_TRUE(found.summary.clean);
  }
}

/** A log whose only record behind the header is a chunk with these contents, its CRC right. */
Bytes logWith(const ChunkedLog& log, const Bytes& contents) {
  Bytes payload(kChunkSpanSize + ZSTD_compressBound(contents.size()));
  payload.resize(kChunkSpanSize + ZSTD_compress(payload.data() + kChunkSpanSize, payload.size() - kChunkSpanSize,
                                                contents.data(), contents.size(), 1));
  Bytes bytes(log.bytes.begin(), log.bytes.begin() + static_cast<std::ptrdiff_t>(log.ends[0]));
  appendFrame({kMagic, RecordType::kChunk, kChunkVersion, static_cast<std::uint32_t>(payload.size()), 1},
              payload.data(), &bytes);
  return bytes;
}

TEST(Chunks, ContentsThatNoWriterMakesAreRefusedAsAWhole) {
  const ChunkedLog log = makeChunkedLog();
  const Bytes good = contentsOf(log);
  ASSERT_EQ(readBack(logWith(log, good)).ids, idsOf(true, false));
  const std::size_t forms = 20 + kPerChunk, orders = forms + 19;
  struct Wrong {
    const char* what;
    std::size_t at;
    std::uint8_t value;
  };
  for (const Wrong& wrong : {Wrong{"more records than groups have", 0, 45}, Wrong{"a group too many", 4, 2},
                             Wrong{"a header in a chunk", 8, 0}, Wrong{"a chunk in a chunk", 8, 14},
                             Wrong{"fewer records in the group", 12, 43}, Wrong{"more numbers", 16, 20},
                             Wrong{"a record of no group", 20, 1}, Wrong{"a number of 3 bytes", forms, 3},
                             Wrong{"a float of 4 bytes", forms, 0x84}, Wrong{"differences of order 5", orders, 5}}) {
    Bytes bad = good;
    bad[wrong.at] = wrong.value;
    const Bytes bytes = logWith(log, bad);
    const ReadBack found = readBack(bytes);
    EXPECT_TRUE(found.ids.empty()) << wrong.what;
    EXPECT_EQ(found.summary.bad_bytes, bytes.size() - log.ends[0]) << wrong.what;
  }
  for (const std::ptrdiff_t less : {1, 1000}) {
    EXPECT_TRUE(readBack(logWith(log, Bytes(good.begin(), good.end() - less))).ids.empty());
  }
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_TRUE(readBack(logWith(log, longer)).ids.empty());
}

TEST(Chunks, AnUnusableRecordInOneLeavesTheOthers) {
  const ChunkedLog log = makeChunkedLog();
  Bytes contents = contentsOf(log);
  const std::size_t data = 20 + kPerChunk + 39;
  // The kind of the third request, a column of one byte: differences of order 0.
  const std::size_t kinds = data + kPerChunk * (8 * 11 + 4 * 2);
  ASSERT_EQ(contents[20 + kPerChunk + 19 + 1], 0) << "order of the kinds' differences";
  contents[kinds + 2] = 200;
  const Bytes bytes = logWith(log, contents);
  const ReadBack found = readBack(bytes);
  std::vector<std::uint32_t> expected = idsOf(true, false);
  expected.erase(expected.begin() + 2);
  EXPECT_EQ(found.ids, expected);
  EXPECT_EQ(found.summary.bad_bytes, bytes.size() - log.ends[0]) << "the chunk's bytes, once";
}

TEST(Chunks, ARecoveryGoesOnBehindThem) {
  const ChunkedLog log = makeChunkedLog();
  std::filesystem::resize_file(log.path, log.ends[1]);
  LogWriter again(log.path, LogPosition{log.ends[1], 1 + kPerChunk});
  RequestRecord record;
  record.request.id = 1234;
  again.write(record);
  again.finishRecovery({});
  const ReadBack found = readBack(readBytes(log.path));
  EXPECT_EQ(found.ids.size(), kPerChunk + 1U);
  EXPECT_EQ(found.ids.back(), 1234U);
  EXPECT_TRUE(found.summary.recovered);
}

/** After 2 s of a full disk the queues come in one batch. No chunk of it is longer than a second. */
TEST(Chunks, NoneHoldsMoreThanASecondOfTicks) {
  const std::string path = scratchPath("late.rlog");
  {
    LogWriter log(path, LogHeader{});
    for (int i = 0; i < 2500; ++i)
      log.write(TickRecord{});
  }
  const Bytes bytes = readBytes(path);
  std::vector<std::uint64_t> numbers;
  for (std::size_t at = 0; at < bytes.size();) {
    const FrameHeader header = decodeFrameHeader(bytes.data() + at);
    numbers.push_back(header.number);
    at += kFrameHeaderSize + header.length + kCrcSize;
  }
  numbers.push_back(2501);
  for (std::size_t i = 1; i + 1 < numbers.size(); ++i)
    EXPECT_LE(numbers[i + 1] - numbers[i], 1000U);
  EXPECT_EQ(readLog(path, {}).records, 2500U);
}

}  // namespace
}  // namespace raven2_trainer::session
