#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "log_file.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/session/session_log.h"
#include "session/header_json.h"
#include "session/record_frame.h"
#include "support/effort.h"

namespace raven2_trainer::session {
namespace {

constexpr int kRecords = 40;

/** Where each record ends in the file, header and footer included. */
struct SmallLog {
  Bytes bytes;
  std::vector<std::size_t> ends;
};

/** Requests 0..39 and the counters; the request's id says which it is. */
SmallLog makeSmallLog() {
  const std::string path = scratchPath("small.rlog");
  {
    LogWriter log(path, LogHeader{});
    for (std::uint32_t i = 0; i < kRecords; ++i) {
      RequestRecord record;
      record.tick = i;
      record.request.id = i;
      log.write(record);
    }
    log.finish({});
  }
  SmallLog small;
  small.bytes = readBytes(path);
  std::size_t end = 0;
  while (end < small.bytes.size()) {
    const std::size_t length = decodeFrameHeader(small.bytes.data() + end).length;
    end += 20 + length + 4;
    small.ends.push_back(end);
  }
  return small;
}

struct Found {
  LogSummary summary;
  std::vector<std::uint32_t> ids;
};

Found readFile(const std::string& path) {
  Found found;
  LogVisitor visitor;
  visitor.request = [&found](const RequestRecord& record) { found.ids.push_back(record.request.id); };
  found.summary = readLog(path, visitor);
  return found;
}

Found readAll(const Bytes& bytes) {
  const std::string path = scratchPath("damaged.rlog");
  writeBytes(path, bytes);
  return readFile(path);
}

/** ids of the records that do not touch [first, last) of the file. */
std::vector<std::uint32_t> idsOutside(const SmallLog& log, std::size_t first, std::size_t last) {
  std::vector<std::uint32_t> ids;
  for (std::uint32_t i = 0; i < kRecords; ++i) {
    if (log.ends[i + 1] <= first || log.ends[i] >= last) ids.push_back(i);
  }
  return ids;
}

TEST(DamagedLog, EndsCleanlyWhereverItIsCut) {
  const SmallLog log = makeSmallLog();
  ASSERT_EQ(log.ends.size(), kRecords + 2u);
  const std::string path = scratchPath("cut.rlog");
  writeBytes(path, log.bytes);
  // Short form: every byte of the first record, of the footer's frame and around each end; of the rest every 16th.
  const auto isLikeOthers = [&](std::size_t cut) {
    const auto end = std::upper_bound(log.ends.begin(), log.ends.end(), cut);
    const std::size_t before = cut - *(end - 1), behind = *end - cut;
    const bool is_footer = end + 1 == log.ends.end();
    const bool is_frame = is_footer ? before <= 24 || behind <= 5 : before <= 1 || behind <= 1;
    return cut > log.ends[1] && !is_frame && cut % 16 != 0;
  };
  for (std::size_t cut = log.bytes.size() - 1; cut >= log.ends[0]; --cut) {
    if (!raven2_trainer::testing::isFull() && isLikeOthers(cut)) continue;
    std::filesystem::resize_file(path, cut);
    const Found found = readFile(path);
    const auto whole = std::upper_bound(log.ends.begin(), log.ends.end(), cut) - log.ends.begin();
    ASSERT_EQ(found.ids, idsOutside(log, cut, log.bytes.size())) << "cut at " << cut;
    ASSERT_FALSE(found.summary.clean);
    ASSERT_EQ(found.summary.bad_bytes, 0u) << "a cut is no damage";
    ASSERT_EQ(found.summary.truncated_bytes, cut - log.ends[static_cast<std::size_t>(whole) - 1]);
  }
}

TEST(DamagedLog, IsRefusedWhenItsHeaderIsCut) {
  const SmallLog log = makeSmallLog();
  const std::string path = scratchPath("cut.rlog");
  writeBytes(path, log.bytes);
  for (std::size_t cut = log.ends[0]; cut-- > 0;) {
    std::filesystem::resize_file(path, cut);
    ASSERT_THROW(readFile(path), SessionException) << "cut at " << cut;
  }
}

TEST(DamagedLog, LosesOnlyTheRecordWithTheFlippedBit) {
  const SmallLog log = makeSmallLog();
  Random random(2017);
  const auto flips = raven2_trainer::testing::effort(250, 1000);
  for (std::int64_t i = 0; i < flips; ++i) {
    const auto span = static_cast<std::uint32_t>(log.bytes.size() - log.ends[0]);
    const std::size_t at_byte = log.ends[0] + random.next() % span;
    Bytes bytes = log.bytes;
    bytes[at_byte] = static_cast<std::uint8_t>(bytes[at_byte] ^ (1U << (random.next() % 8)));
    const Found found = readAll(bytes);
    ASSERT_EQ(found.ids, idsOutside(log, at_byte, at_byte + 1)) << "bit in byte " << at_byte;
    const auto hit = std::upper_bound(log.ends.begin(), log.ends.end(), at_byte);
    ASSERT_EQ(found.summary.bad_bytes + found.summary.truncated_bytes, *hit - *(hit - 1));
    ASSERT_EQ(found.summary.clean, hit + 1 != log.ends.end());
  }
}

TEST(DamagedLog, ACutBehindADamagedRecordIsStillDamage) {
  const SmallLog log = makeSmallLog();
  const std::size_t damaged = log.ends[kRecords - 1], last = log.ends[kRecords];
  Bytes bytes(log.bytes.begin(), log.bytes.begin() + static_cast<std::ptrdiff_t>(last + 10));
  bytes[damaged + 30] ^= 1;  // of the record before the one that is cut
  const Found found = readAll(bytes);
  EXPECT_EQ(found.ids.size(), kRecords - 1U);
  EXPECT_EQ(found.summary.bad_bytes, bytes.size() - damaged);
  EXPECT_EQ(found.summary.truncated_bytes, 0U);
}

TEST(DamagedLog, LosesOnlyWhatABurstOfGarbageHits) {
  const SmallLog log = makeSmallLog();
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    Bytes bytes = log.bytes;
    const std::size_t first = log.ends[0] + random.next() % 2000;
    const std::size_t last = first + 1 + random.next() % 300;
    for (std::size_t b = first; b < last; ++b)
      bytes[b] = static_cast<std::uint8_t>(~bytes[b]);
    ASSERT_EQ(readAll(bytes).ids, idsOutside(log, first, last)) << first << " to " << last;
  }
}

TEST(DamagedLog, SurvivesInsertedBytes) {
  const SmallLog log = makeSmallLog();
  Bytes bytes = log.bytes;
  const Bytes junk{'R', 'V', '2', 'L', 1, 0, 1, 0, 0xFF, 0xFF, 0xFF, 0xFF, 'R', 'V', '2', 'L', 'R', 'V', '2'};
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(log.ends[7]), junk.begin(), junk.end());
  const Found found = readAll(bytes);
  EXPECT_EQ(found.ids.size(), static_cast<std::size_t>(kRecords));
  EXPECT_EQ(found.summary.bad_bytes, junk.size());
  EXPECT_TRUE(found.summary.clean);
}

TEST(DamagedLog, NeverCrashesOnRandomBytes) {
  const SmallLog log = makeSmallLog();
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    // GIVEN a good header and then noise, rich in magics
    Bytes bytes(log.bytes.begin(), log.bytes.begin() + static_cast<std::ptrdiff_t>(log.ends[0]));
    for (int n = 0; n < 500; ++n) {
      const Bytes piece = random.next() % 8 == 0
                              ? Bytes{'R', 'V', '2', 'L', static_cast<std::uint8_t>(random.next() % 8)}
                              : Bytes{static_cast<std::uint8_t>(random.next())};
      bytes.insert(bytes.end(), piece.begin(), piece.end());
    }
    const Found found = readAll(bytes);
    EXPECT_TRUE(found.ids.empty());
    EXPECT_EQ(found.summary.bad_bytes + found.summary.truncated_bytes, bytes.size() - log.ends[0]);
  }
}

/** A sealed record of any content. */
Bytes sealed(std::uint16_t type, std::uint16_t version, const Bytes& payload) {
  Bytes bytes(kFrameHeaderSize);
  encodeFrameHeader({kMagic, static_cast<RecordType>(type), version, static_cast<std::uint32_t>(payload.size()), 1},
                    bytes.data());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  const std::uint32_t crc = crc32Of(bytes.data(), bytes.size());
  for (unsigned i = 0; i < 4; ++i)
    bytes.push_back(static_cast<std::uint8_t>(crc >> (8 * i)));
  return bytes;
}

Found readWithRecord(const Bytes& record) {
  const SmallLog log = makeSmallLog();
  Bytes bytes(log.bytes.begin(), log.bytes.begin() + static_cast<std::ptrdiff_t>(log.ends[0]));
  bytes.insert(bytes.end(), record.begin(), record.end());
  return readAll(bytes);
}

constexpr std::size_t kRequestSize = 8 + 6 + 3 * 8 + 7 * 8 + 2 * 4;  ///< [bytes] tick, bytes, goals, numbers

TEST(DamagedLog, RefusesAValueBeyondItsEnumEvenWithARightCrc) {
  Bytes request(kRequestSize);
  request[8] = 200;  // RequestKind has 24
  const Bytes record = sealed(4, kRecordVersion, request);
  const Found found = readWithRecord(record);
  EXPECT_TRUE(found.ids.empty());
  EXPECT_EQ(found.summary.bad_bytes, record.size());
}

TEST(DamagedLog, RefusesAPlanWithMoreWaypointsThanItHolds) {
  Bytes plan(8 + 4 + 2 + 4 + 64 * 64 + 4 * 8 + 4 + 1 + 1);
  plan[14] = 65;  // waypoint_count, of at most 64
  EXPECT_EQ(readWithRecord(sealed(5, kRecordVersion, plan)).summary.records, 0u);
  plan[14] = 64;
  EXPECT_EQ(readWithRecord(sealed(5, kRecordVersion, plan)).summary.records, 1u);
}

TEST(DamagedLog, RefusesARecordOfTheWrongLength) {
  for (const std::size_t size : {std::size_t{0}, kRequestSize - 1, kRequestSize + 1}) {
    EXPECT_EQ(readWithRecord(sealed(4, kRecordVersion, Bytes(size))).summary.records, 0u) << size;
  }
  EXPECT_EQ(readWithRecord(sealed(4, kRecordVersion, Bytes(kRequestSize))).summary.records, 1u);
}

TEST(DamagedLog, PassesOverKindsAndVersionsItDoesNotKnow) {
  for (const Bytes& record : {sealed(77, kRecordVersion, Bytes(10)), sealed(4, kRecordVersion + 1, Bytes(120))}) {
    const Found found = readWithRecord(record);
    EXPECT_TRUE(found.ids.empty());
    EXPECT_EQ(found.summary.bad_bytes, 0u);
  }
}

TEST(DamagedLog, IsNoLogIfMissingOrAFolder) {
  EXPECT_THROW(readLog(scratchPath("missing.rlog"), {}), SessionException);
  EXPECT_THROW(readLog(::testing::TempDir(), {}), SessionException);
}

TEST(DamagedLog, IsRefusedWithAnotherFormatVersion) {
  const std::string json = R"({"format": "raven2_trainer session log", "format_version": 4})";
  const std::string path = scratchPath("newer.rlog");
  Bytes bytes = sealed(0, kRecordVersion, Bytes(json.begin(), json.end()));
  writeBytes(path, bytes);
  try {
    readLog(path, {});
    FAIL() << "was read";
  } catch (const SessionException& error) {
    EXPECT_NE(std::string(error.what()).find("format version 4"), std::string::npos) << error.what();
  }
}

/** Reads a log that holds nothing but this header. */
LogHeader readHeaderOf(const nlohmann::ordered_json& json) {
  const std::string text = json.dump();
  const std::string path = scratchPath("header_only.rlog");
  writeBytes(path, sealed(0, kRecordVersion, Bytes(text.begin(), text.end())));
  return readLogHeader(path);
}

TEST(DamagedLog, IsRefusedWithAnotherLayoutOfItsRecords) {
  // A reader that went on would pass over every tick and call the session empty.
  const auto ours = nlohmann::ordered_json::parse(headerToJson(LogHeader{}));
  EXPECT_NO_THROW(readHeaderOf(ours));
  auto longer = ours;
  longer["records"][0]["fields"][0]["fields"].erase(3);
  EXPECT_THROW(readHeaderOf(longer), SessionException);
  auto newer = ours;
  newer["records"][1]["version"] = kRecordVersion + 1;
  EXPECT_THROW(readHeaderOf(newer), SessionException);
  auto fewer = ours;
  fewer["records"].erase(4);
  EXPECT_THROW(readHeaderOf(fewer), SessionException);
  auto reworded = ours;
  reworded["records"][0]["fields"][0]["meaning"] = "the model";
  EXPECT_NO_THROW(readHeaderOf(reworded));
  auto more = ours;
  more["records"].push_back({{"type", 50}, {"name", "new"}, {"version", 1}, {"fields", nlohmann::json::array()}});
  EXPECT_NO_THROW(readHeaderOf(more));
}

}  // namespace
}  // namespace raven2_trainer::session
