#include <zstd.h>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/session_log.h"
#include "session/record_chunk.h"
#include "session/record_frame.h"

// The reader of session logs. Input: a byte, then the file. If bit 0 of the byte is set, the file begins with a good
// first record, and the rest of the input is records (type, flags, length as 16 bits, payload). They get a correct CRC,
// so that their values pass it, unless flag bit 0 is set. With flag bit 2 the payload is the contents of a chunk, which
// are compressed here; with bit 3, too, of a chunk of version 1, without formulas.

namespace raven2_trainer::fuzz {
namespace {

using session::FrameHeader;

const ScratchFolder& scratch() {
  static const ScratchFolder folder;
  return folder;
}

/** A log with only the first record. */
const std::string& goodStart() {
  static const std::string bytes = [] {
    const std::string path = scratch().path("start.rlog");
    session::LogWriter(path, session::LogHeader{}).finish({});
    const std::string all = readWhole(path);
    const auto* data = reinterpret_cast<const std::uint8_t*>(all.data());
    return all.substr(0, session::kFrameHeaderSize + session::decodeFrameHeader(data).length + session::kCrcSize);
  }();
  return bytes;
}

Bytes compressed(const Bytes& contents) {
  constexpr std::size_t kSpan = session::kChunkSpanSize;
  Bytes bytes(kSpan + ZSTD_compressBound(contents.size()));
  bytes.resize(kSpan + ZSTD_compress(bytes.data() + kSpan, bytes.size() - kSpan, contents.data(), contents.size(), 1));
  return bytes;
}

std::string framed(Input* input, std::uint64_t number) {
  FrameHeader header;
  header.magic = session::kMagic;
  header.type = static_cast<session::RecordType>(input->byte());
  const std::uint8_t flags = input->byte();
  header.version = (flags & 2U) == 0 ? session::kRecordVersion : input->byte();
  Bytes payload = input->take(input->word());
  if ((flags & 4U) != 0) {
    header.type = session::RecordType::kChunk;
    header.version = (flags & 8U) != 0 ? 1 : session::kChunkVersion;
    payload = compressed(payload);
  }
  header.length = static_cast<std::uint32_t>(payload.size());
  header.number = number;
  Bytes bytes(session::kFrameHeaderSize);
  session::encodeFrameHeader(header, bytes.data());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  const std::uint32_t crc = session::crc32Of(bytes.data(), bytes.size()) ^ (flags & 1U);
  const auto* tail = reinterpret_cast<const std::uint8_t*>(&crc);
  bytes.insert(bytes.end(), tail, tail + sizeof(crc));
  return std::string(bytes.begin(), bytes.end());
}

std::string fileOf(Input* input) {
  if ((input->byte() & 1U) == 0) return input->rest();
  std::string file = goodStart();
  for (std::uint64_t number = 1; !input->empty(); ++number)
    file += framed(input, number);
  return file;
}

void read(const std::string& path, std::size_t size) {
  std::uint64_t seen = 0;
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& r) {
    require(static_cast<std::size_t>(r.robot.runlevel) < kRunLevelNames.size(), "an enum is one of its names");
    ++seen;
  };
  visitor.haptic = [&](const HapticRecord&) { ++seen; };
  visitor.command = [&](const CommandRecord&) { ++seen; };
  visitor.request = [&](const RequestRecord& r) {
    require(static_cast<std::size_t>(r.request.kind) < kRequestKindCount, "an enum is one of its names");
    ++seen;
  };
  visitor.plan = [&](const PlanRecord& r) {
    require(r.result.waypoint_count <= kMaxWaypoints, "a count is within its array");
    ++seen;
  };
  visitor.execution = [&](const ExecutionRecord& r) {
    require(static_cast<std::size_t>(r.report.end) < kExecutionEndCount, "an enum is one of its names");
    ++seen;
  };
  visitor.exercise = [&](const ExerciseRecord& r) {
    require(static_cast<std::size_t>(r.event.kind) < kExerciseEventKindCount &&
                static_cast<std::size_t>(r.event.mistake) < kMistakeCount,
            "an enum is one of its names");
    ++seen;
  };
  visitor.contact = [&](const ContactRecord&) { ++seen; };
  visitor.counts = [&](const SessionCounts&) { ++seen; };
  const session::LogSummary summary = session::readLog(path, visitor);
  require(seen <= summary.records, "every record given is counted");
  require(summary.bad_bytes + summary.truncated_bytes <= size, "no byte is counted twice");
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  fuzz::Input input(data, size);
  const std::string file = fuzz::fileOf(&input);
  const std::string path = fuzz::scratch().write("fuzzed.rlog", file);
  try {
    fuzz::read(path, file.size());
  } catch (const SessionException&) {  // refused: not a log
  }
  return 0;
}
